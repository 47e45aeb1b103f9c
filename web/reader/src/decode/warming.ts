// Browsers compile WebAssembly twice: quickly, and well where it has run for a while. A worker that
// has nothing to do yet decodes two small files until the decoders are compiled well, for all
// workers: they share the module.
import { EngineFile } from "./engine.js";
import grey from "../../../../tests/golden/v1/small-uint8-thick.8vo";
import labels from "../../../../tests/golden/v1/labels-uint8.8vo";

const warmingMs = 300;

export async function warm(module: WebAssembly.Module): Promise<void> {
  for (const bytes of [grey, labels]) {
    const own = new Uint8Array(bytes);
    const file = new EngineFile(module, {
      name: "warming", size: own.length, cacheBytes: 0, parts: [{ offset: 0, bytes: own }] });
    await file.put({ offset: 0, bytes: own });
    const end = performance.now() + warmingMs / 2;
    while (performance.now() < end) {
      await file.use((exports, volume, engine) => {
        const level = engine.text(exports.octavo_describe(volume));
        const { size } = JSON.parse(level) as { size: [number, number, number] };
        const out = exports.octavo_allocate(4 * size[0] * size[1] * size[2]);
        engine.withBox([0, 0, 0, ...size], (box) => exports.octavo_read(volume, box, 0, out));
        exports.octavo_free(out);
      });
      // Jobs go first.
      await new Promise((resolve) => setTimeout(resolve, 0));
    }
  }
}
