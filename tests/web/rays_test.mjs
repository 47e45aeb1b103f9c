// The 3-D view in Chromium: labels over a scan and alone, projections of values that fall as stored
// ones rise, what its line says, and what it keeps on the graphics card.
//
// usage: OCTAVO=build/octavo node tests/web/rays_test.mjs
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { inFolder, run } from "./support/golden.mjs";
import { niftiBytes } from "./support/nifti.mjs";
import { pngPixels } from "./support/png.mjs";
import {
  panelPng, settled, showRaysAlone, startPage, text, withPage as withLargePage,
} from "./support/viewer_page.mjs";

const SIDE = 160;
// Farther apart than any table of colors by the number itself is long.
const [NEAR, FAR] = [1, 70001];
// As src/octavo/core/label_color.cpp gives them.
const COLORS = { [NEAR]: [105, 142, 230], [FAR]: [0, 0, 0] };

/** Few pixels, which a processor draws in place of a graphics card. */
const withPage = (query, use) =>
  withLargePage(query, use, { viewport: { width: 400, height: 340 } });

let host;
let files;
let projected;
before(async () => {
  ({ host, files } = await startPage());
  await inFolder((folder) => {
    const at = (name) => join(folder, name);
    const [nx, ny, nz] = files.size;
    const labels = new Uint32Array(nx * ny * nz);
    const falling = new Int16Array(nx * ny * nz);
    for (let z = 0, i = 0; z < nz; ++z) {
      for (let y = 0; y < ny; ++y) {
        for (let x = 0; x < nx; ++x, ++i) {
          const ball = (cx, r) => Math.hypot(x - cx, y - 65, z - 45) < r;
          labels[i] = ball(40, 22) ? NEAR : ball(110, 22) ? FAR : 0;
          // The brightest lies behind, in another page; in each page something is dark.
          falling[i] = Math.hypot(x - 75, y - 110, z - 45) < 12 ? -900
            : Math.hypot(x - 75, y - 20, z - 45) < 30 ? -300 : (x * 7 + y * 5 + z * 3) % 50;
        }
      }
    }
    writeFileSync(at("apart.raw"), labels);
    run("build", at("apart.raw"), "--raw", `${nx},${ny},${nz},uint32`, "--spacing", "0.8,0.8,1.2",
      "--labels", "-o", at("apart.8vo"));
    writeFileSync(at("falling.nii"), niftiBytes(falling, files.size, [0.8, 0.8, 1.2], -1, 0));
    run("build", at("falling.nii"), "-o", at("falling.8vo"));
    run("render", at("falling.8vo"), "--mode", "mip", "--window", "450,900", "--azimuth", "0",
      "--elevation", "0", "--size", `${SIDE}x${SIDE}`, "--no-legend", "--no-sides",
      "--no-scale-bar", "-o", at("mip.png"));
    projected = pngPixels(readFileSync(at("mip.png")));
    for (const name of ["apart.8vo", "falling.8vo"]) {
      host.files.set(`/${name}`, readFileSync(at(name)));
    }
  });
});
after(() => host.close());

const picture = async (shown) => pngPixels(await panelPng(shown, "panel-3d"));

/** Pixels whose color is another one lit more or less: red, green and blue in the same shares. */
function pixelsLike(seen, [r, g, b]) {
  const length = Math.hypot(r, g, b);
  let count = 0;
  for (let i = 0; i < seen.width * seen.height; ++i) {
    const [x, y, z] = seen.rgb.subarray(3 * i, 3 * i + 3);
    const size = Math.hypot(x, y, z);
    if (size > 60 && (x * r + y * g + z * b) / size / length > 0.995) count += 1;
  }
  return count;
}

test("labels far apart have colors of their own, over a scan as alone", async () => {
  for (const query of ["?url=apart.8vo&layout=3d&camera=0,0,1",
    "?url=scan.8vo&labels=apart.8vo&layout=3d&camera=0,0,1&mode=iso&iso=5000&opacity=1"]) {
    await withPage(query, async (shown) => {
      await shown.waitForFunction(
        () => document.querySelectorAll("#labels li").length === 2);
      await showRaysAlone(shown, SIDE);
      const far = await shown.evaluate((label) => {
        const row = document.querySelector(`#labels input[data-label="${label}"]`).parentElement;
        return row.querySelector(".swatch").style.backgroundColor.match(/\d+/g).map(Number);
      }, FAR);
      let seen = await picture(shown);
      const both = [pixelsLike(seen, COLORS[NEAR]), pixelsLike(seen, far)];
      assert.ok(both.every((count) => count > 300), `${query} ${both}`);
      await shown.evaluate((label) => octavo.store.set({ hiddenLabels: new Set([label]) }), FAR);
      seen = await picture(shown);
      const one = [pixelsLike(seen, COLORS[NEAR]), pixelsLike(seen, far)];
      assert.ok(one[0] > 300 && one[1] === 0, `${query} ${one}`);
    });
  }
});

test("labels shine through the surface of a scan as much as is asked for", async () => {
  const query = "?url=scan.8vo&labels=apart.8vo&layout=3d&camera=0,0,1&mode=mip&window=4000,1";
  await withPage(query, async (shown) => {
    await shown.waitForFunction(() => octavo.overlay?.hasPreview);
    await showRaysAlone(shown, SIDE);
    const brightest = async (opacity) => {
      await shown.evaluate((share) => octavo.store.set({ overlayOpacity: share }), opacity);
      const seen = await picture(shown);
      return Math.max(...seen.rgb);
    };
    const [none, half, all] = [await brightest(0), await brightest(0.5), await brightest(1)];
    assert.ok(none < 30 && half > 80 && all > 1.6 * half, `${none} ${half} ${all}`);
  });
});

test("a projection shows the largest real values where they fall as stored ones rise", async () => {
  await withPage("?url=falling.8vo&layout=3d&camera=0,0,1&mode=mip&window=450,900",
    async (shown) => {
      await showRaysAlone(shown, SIDE);
      const seen = await picture(shown);
      let [differing, bright] = [0, 0];
      for (let i = 0; i < SIDE * SIDE; ++i) {
        bright += projected.grey[i] > 240 ? 1 : 0;
        // Of a voxel's width at the rims of the balls.
        differing += Math.abs(projected.grey[i] - seen.grey[i]) > 40 ? 1 : 0;
      }
      assert.ok(bright > 200, `${bright} bright pixels`);
      assert.ok(differing < bright * 0.15, `${differing} differ, ${bright} are bright`);
    });
});

/** The scan in floats, times a power of two; where `hasHoles`, slabs of NaN and one infinity. */
function floats(power, hasHoles) {
  return inFolder((folder) => {
    const [nx, ny, nz] = [64, 64, 48];
    const voxels = new Float32Array(nx * ny * nz);
    for (let z = 0, i = 0; z < nz; ++z) {
      for (let y = 0; y < ny; ++y) {
        for (let x = 0; x < nx; ++x, ++i) {
          const isIn = Math.hypot((x - 31) / 24, (y - 31) / 28, (z - 23) / 20) < 1;
          voxels[i] = (isIn ? 500 + 4 * x : -300) * 2 ** power;
          if (hasHoles && z % 7 === 0) voxels[i] = NaN;
        }
      }
    }
    if (hasHoles) voxels[(3 * ny + 3) * nx + 3] = Infinity;
    writeFileSync(join(folder, "f.raw"), voxels);
    run("build", join(folder, "f.raw"), "--raw", `${nx},${ny},${nz},float32`, "--spacing", "1",
      "-o", join(folder, "f.8vo"));
    host.files.set("/floats.8vo", readFileSync(join(folder, "f.8vo")));
    run("render", join(folder, "f.8vo"), "--mode", "mip", "--window", "350,700", "--azimuth",
      "30", "--elevation", "20", "--size", `${SIDE}x${SIDE}`, "--no-legend", "--no-sides",
      "--no-scale-bar", "-o", join(folder, "f.png"));
    return pngPixels(readFileSync(join(folder, "f.png")));
  });
}

/** The floats in each mode of the 3-D view, and a slice. */
async function seenFloats(power) {
  const times = 2 ** power;
  const seen = {};
  const window = encodeURIComponent(`${350 * times},${700 * times}`);
  await withPage(`?url=floats.8vo&layout=3d&window=${window}`, async (shown) => {
    await showRaysAlone(shown, SIDE);
    for (const mode of ["volume", "mip", "iso"]) {
      await shown.evaluate(([now, iso]) => octavo.store.set({ mode: now, iso }),
        [mode, 200 * times]);
      seen[mode] = await picture(shown);
    }
    await shown.evaluate(() => octavo.store.set({ layout: "z" }));
    seen.slice = pngPixels(await panelPng(shown, "panel-z"));
  });
  return seen;
}

const brightPixels = ({ grey }) => grey.filter((v) => v > 60).length;

test("voxels that are NaN or infinite hide no others", async () => {
  await floats(0, false);
  const whole = await seenFloats(0);
  const rendered = await floats(0, true);
  const seen = await seenFloats(0);
  let [differing, bright] = [0, 0];
  for (let i = 0; i < SIDE * SIDE; ++i) {
    bright += rendered.grey[i] > 60 ? 1 : 0;
    differing += Math.abs(rendered.grey[i] - seen.mip.grey[i]) > 40 ? 1 : 0;
  }
  assert.ok(bright > 3000 && differing < bright * 0.1, `${differing} differ, ${bright} bright`);
  for (const mode of ["volume", "iso"]) {
    const [all, now] = [whole[mode], seen[mode]].map(brightPixels);
    assert.ok(all > 3000 && now > 0.7 * all, `${mode}: ${now} of ${all}`);
  }
});

test("a scan looks the same whatever the power of two that its floats are multiplied by", async () => {
  await floats(0, false);
  const usual = await seenFloats(0);
  for (const power of [117, -110]) {
    await floats(power, false);
    const seen = await seenFloats(power);
    for (const [name, { grey }] of Object.entries(usual)) {
      const differing = grey.filter((v, i) => Math.abs(v - seen[name].grey[i]) > 3).length;
      assert.ok(brightPixels(usual[name]) > 3000 && differing < 100,
        `2^${power} ${name}: ${differing} differ`);
    }
  }
});

test("the line of the 3-D view is of the picture that is seen", async () => {
  await withPage("?url=scan.8vo&layout=3d&mode=iso&iso=600&camera=30,20,3", async (shown) => {
    await settled(shown);
    assert.deepEqual(await shown.evaluate(() => octavo.rays.fidelity()), { level: 0, isFinal: true });
    const label = () => shown.locator("#panel-3d").getAttribute("aria-label");
    assert.equal(await label(), "3-D view, 1/1 of full resolution");
    // While it turns few rays are drawn, of whatever level.
    const turned = await shown.evaluate(() => {
      octavo.store.set({ camera: { azimuth: 77, elevation: 10, zoom: 3 } });
      return new Promise((resolve) => {
        const look = () => {
          const found = octavo.rays.fidelity();
          if (!found.isFinal) resolve(document.getElementById("panel-3d").ariaLabel);
          else requestAnimationFrame(look);
        };
        look();
      });
    });
    assert.match(turned, /, draft$/);
    await settled(shown);
    await shown.waitForFunction(
      () => document.getElementById("panel-3d").ariaLabel.endsWith("of full resolution"));
    assert.equal(await text(shown, "fidelity"), "full resolution");
  });
});

test("what is opened next does not add to what is on the graphics card", async () => {
  await withPage("?url=scan.8vo&labels=labels.8vo", async (shown) => {
    await shown.waitForFunction(() => octavo.overlay?.hasPreview);
    await settled(shown);
    const alive = await shown.evaluate(async () => {
      const counts = [];
      let alive = 0;
      const { prototype } = WebGL2RenderingContext;
      for (const kind of ["Texture", "Program", "Shader", "Framebuffer"]) {
        const [create, remove] = [prototype[`create${kind}`], prototype[`delete${kind}`]];
        prototype[`create${kind}`] = function made(...of) {
          alive += 1;
          return create.apply(this, of);
        };
        prototype[`delete${kind}`] = function gone(...of) {
          alive -= 1;
          return remove.apply(this, of);
        };
      }
      for (let i = 0; i < 4; ++i) {
        await octavo.open("scan.8vo");
        while (!octavo.rays.isSettled || !octavo.session.hasPreview) {
          await new Promise((resolve) => setTimeout(resolve, 50));
        }
        counts.push(alive);
      }
      return counts;
    });
    assert.ok(alive.every((count) => count <= 0), `${alive}`);
  });
});

test("a region is measured once for each level that comes", async () => {
  await withPage("?url=scan.8vo&layout=z&at=75,65,40", async (shown) => {
    await settled(shown);
    const before = await shown.evaluate(() => {
      octavo.store.set({ measurements: [
        { kind: "roi", axis: 2, slice: 40, points: [[20, 20, 40], [120, 110, 40]] }] });
      return octavo.measures.regionsMeasured;
    });
    await shown.waitForFunction(() => /mean .* samples✕$/.test(
      document.getElementById("measurements").textContent));
    const line = await text(shown, "measurements");
    // Cells of other places come.
    for (const z of [5, 20, 60, 85]) {
      await shown.evaluate((at) => octavo.store.set({ at: [75, 65, at] }), z);
      await settled(shown);
    }
    const after = await shown.evaluate(() => octavo.measures.regionsMeasured);
    assert.ok(after - before <= 2, `${after - before} times`);
    assert.equal(await text(shown, "measurements"), line);
  });
});
