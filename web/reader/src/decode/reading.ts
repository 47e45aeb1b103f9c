// A box of a file out of an instance, which says what it lacks until nothing is missing.
import type { PlacedBytes } from "../store/file_bytes.js";
import type { ByteRange } from "../store/ranges.js";
import type { EngineFile } from "./engine.js";
import type { JobOptions } from "./decoders.js";
import { bytesPerVoxel } from "./messages.js";

/** Coded bytes kept in an instance between two boxes. */
const keptBytes = 4 * 1024 * 1024;

/**
 * The voxels of a box; null where `bring` gives null.
 * bring  the bytes of ranges
 */
export async function voxelsOf(
  file: EngineFile, job: Pick<JobOptions, "box" | "level" | "type">,
  bring: (ranges: readonly ByteRange[]) => Promise<readonly PlacedBytes[] | null>,
): Promise<ArrayBuffer | null> {
  for (;;) {
    const plan = await file.use((exports, volume, engine) => engine.withBox(job.box, (box) =>
      engine.plan(exports.octavo_plan(volume, box, job.level))));
    if (plan.ranges.length === 0 && plan.isComplete) break;
    const parts = await bring(plan.ranges);
    if (parts === null) return null;
    for (const part of parts) await file.put(part);
  }
  const [x0, y0, z0, x1, y1, z1] = job.box as [number, number, number, number, number, number];
  const byteLength = (x1 - x0) * (y1 - y0) * (z1 - z0) * bytesPerVoxel[job.type];
  return file.use((exports, volume, engine) => {
    const out = exports.octavo_allocate(byteLength);
    engine.withBox(job.box, (box) => exports.octavo_read(volume, box, job.level, out));
    const voxels = exports.memory.buffer.slice(out, out + byteLength);
    exports.octavo_free(out);
    exports.octavo_forget(volume, keptBytes);
    return voxels;
  });
}
