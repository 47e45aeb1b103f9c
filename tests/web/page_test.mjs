// The page of the viewer in Chromium: pixels and values are those of the program.
//
// usage: OCTAVO=build/octavo node tests/web/page_test.mjs
import assert from "node:assert/strict";
import { after, before, test } from "node:test";
import { pngPixels } from "./support/png.mjs";
import {
  panelPng, settled, showPanelsAlone, startPage, text, withPage,
} from "./support/viewer_page.mjs";

let host;
let files;
before(async () => {
  ({ host, files } = await startPage());
});
after(() => host.close());

test("a slice has the pixels of octavo slice, and values those of octavo probe", async () => {
  await withPage("?url=scan.8vo&layout=z&at=75,65,40&window=100,600", async (shown) => {
    await settled(shown);
    // As many pixels as the slice has voxels.
    const [w, h] = files.size;
    await showPanelsAlone(shown, [w, h]);
    const seen = pngPixels(await panelPng(shown, "panel-z"));
    assert.deepEqual([seen.width, seen.height], [files.slice.width, files.slice.height]);
    let largest = 0;
    for (let i = 0; i < w * h; ++i) {
      largest = Math.max(largest, Math.abs(seen.grey[i] - files.slice.grey[i]));
    }
    assert.ok(largest <= 1, `a pixel differs by ${largest}`);

    for (const point of files.probed) {
      await shown.evaluate((at) => octavo.store.set({ at }), point.index);
      await settled(shown);
      await shown.waitForFunction((at) => {
        const line = document.getElementById("readout").textContent;
        return line.startsWith(`voxel ${at.join(", ")} `) && !line.includes("(of 1/");
      }, point.index);
      const line = await text(shown, "readout");
      assert.match(line, new RegExp(` ${point.real}( · |$)`), line);
      assert.ok(line.endsWith(`o-code ${point.o_code.mixed_octal}`), line);
    }
  }, { mayComplain: true });
});

test("the first picture is coarse and says so; then all of it is there", async () => {
  await withPage("?url=scan.8vo", async (shown) => {
    await shown.waitForFunction(() => globalThis.octavo?.firstTraffic);
    const first = await shown.evaluate(() => octavo.firstTraffic);
    assert.ok(first.requests <= 3 && first.bytes <= 300_000, JSON.stringify(first));
    await settled(shown);
    await shown.waitForFunction(
      () => document.getElementById("fidelity").textContent.startsWith("full resolution"));
    assert.equal(await shown.evaluate(() => octavo.rays.fidelity().isFinal), true);
  });
});
