// A scan of the size of a chest in the page: requests, values, pixels, and memory while it is flown
// through. Of the shared data where they are there, else of a phantom. Figures are printed.
//
// usage: OCTAVO=build/octavo node tests/web/large_test.mjs
import assert from "node:assert/strict";
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { inChromium, newPage, patienceMs } from "./support/chromium.mjs";
import { dist, root, run } from "./support/golden.mjs";
import { pngPixels } from "./support/png.mjs";
import { memoryOf } from "./support/process_memory.mjs";
import { startServer } from "./support/server.mjs";
import {
  panelPng, settled, showPanelsAlone, showRaysAlone, text,
} from "./support/viewer_page.mjs";

const { createPool, open } = await import(join(dist, "reader-node.js"));
const shared = process.env.OCTAVO_SHARED_DATA ?? join(root, "../shared/data");
const chest = join(shared, "ct_chest_lidc0314");
const skull = join(shared, "cranium/cranium.mhd");
const flightSeconds = 60;
/** What the page may take while it flies: voxels kept, bytes kept, the atlas, workers, and itself. */
const mostMemory = 900e6;

let folder;
let host;
const at = (name) => join(folder, name);
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "octavo-large-"));
  if (existsSync(chest)) run("build", chest, "-o", at("chest.8vo"));
  else run("phantom", "--size", "512,512,275", "--noise", "15", "-o", at("chest.8vo"));
  if (existsSync(skull)) run("build", skull, "-o", at("skull.8vo"));
  host = await startServer({ "/": join(root, "web/viewer/dist"), "/files/": folder });
  for (const name of ["chest.8vo", "skull.8vo"]) {
    if (existsSync(at(name))) host.files.set(`/${name}`, readFileSync(at(name)));
  }
  host.files.set("/favicon.ico", Buffer.alloc(0));
});
after(async () => {
  await host.close();
  rmSync(folder, { recursive: true, force: true });
});

const fetched = () => {
  const entries = host.log.filter(({ path }) => path.endsWith(".8vo"));
  return { requests: entries.length, bytes: entries.reduce((sum, { bytes }) => sum + bytes, 0) };
};

test("a slice takes few requests", async () => {
  const pool = await createPool({ workers: 1 });
  for (const [axis, most] of [[2, 8], [0, 32], [1, 32]]) {
    const scan = await open(`${host.url}/chest.8vo`, { pool });
    const lo = [0, 0, 0];
    const hi = [...scan.size];
    lo[axis] = Math.floor(scan.size[axis] / 2);
    hi[axis] = lo[axis] + 1;
    host.log.length = 0;
    await scan.read({ lo, hi }, 0);
    const { requests, bytes } = fetched();
    console.log(`slice ${"xyz"[axis]}: ${requests} requests, ${bytes} bytes`);
    assert.ok(requests <= most, `${requests} requests`);
    scan.close();
  }
  pool.close();
});

/** The page over a file, in a browser that says that its machine has so many GB. */
async function inPage(query, viewport, use, gigabytes = 8) {
  host.log.length = 0;
  await inChromium(async (browser) => {
    const context = await browser.newContext({ viewport });
    context.setDefaultTimeout(patienceMs);
    await context.addInitScript((n) => {
      Object.defineProperty(Navigator.prototype, "deviceMemory", { get: () => n });
    }, gigabytes);
    const page = await newPage(context, `${host.url}/index.html${query}`);
    await use(page);
    assert.deepEqual(page.errors, []);
  });
}

test("the first picture takes three requests and 300 kB, the slice on the screen few more",
  async () => {
    await inPage("?url=chest.8vo&layout=z", { width: 900, height: 640 }, async (page) => {
      await page.waitForFunction(() => globalThis.octavo?.firstTraffic);
      const first = await page.evaluate(() => octavo.firstTraffic);
      assert.ok(first.requests <= 3 && first.bytes <= 300_000, JSON.stringify(first));
      await settled(page);
      await page.waitForFunction(
        () => document.getElementById("fidelity").textContent.startsWith("full resolution"));
      const all = fetched();
      console.log(`first picture ${JSON.stringify(first)}, full ${JSON.stringify(all)}`);
      assert.ok(all.requests <= 3 + 8 + 8, JSON.stringify(all));
    });
  });

test("50 places have the values of octavo probe, a slice the pixels of octavo slice", async () => {
  const { size } = await sizeOf();
  let state = 7;
  const random = (below) => {
    state = (state * 48271) % 2147483647;
    return state % below;
  };
  const places = Array.from({ length: 50 }, () => size.map(random));
  const { points } = JSON.parse(run("probe", at("chest.8vo"),
    ...places.flatMap((place) => ["--at", place.join(",")]), "--json"));
  const z = Math.floor(size[2] / 2);
  run("slice", at("chest.8vo"), "--axis", "z", "--index", `${z}`, "--window", "40,400", "--size",
    "1", "--no-scale-bar", "--no-sides", "--no-notes", "-o", at("slice.png"));
  const slice = pngPixels(readFileSync(at("slice.png")));
  const query = `?url=chest.8vo&layout=z&at=256,256,${z}&window=40,400`;
  await inPage(query, { width: size[0] + 40, height: size[1] + 200 }, async (page) => {
    await settled(page);
    await showPanelsAlone(page, size);
    const seen = pngPixels(await panelPng(page, "panel-z"));
    assert.deepEqual([seen.width, seen.height], [slice.width, slice.height]);
    const differing = seen.grey.reduce(
      (most, value, i) => Math.max(most, Math.abs(value - slice.grey[i])), 0);
    assert.ok(differing <= 1, `a pixel differs by ${differing}`);
    // Fewer pixels: what lies around a place is not wanted in full.
    await page.evaluate(() => {
      document.getElementById("main").style.width = "80px";
      document.getElementById("main").style.height = "80px";
    });
    for (const point of points) {
      await page.evaluate((place) => octavo.store.set({ at: place }), point.index);
      await page.waitForFunction((place) => {
        const line = document.getElementById("readout").textContent;
        return line.startsWith(`voxel ${place.join(", ")} `) && !/\(of 1\/|…/.test(line);
      }, point.index);
      const line = await text(page, "readout");
      assert.match(line, new RegExp(` ${point.real}( · | HU)`), line);
      assert.ok(line.endsWith(`o-code ${point.o_code.mixed_octal}`), line);
    }
  });
});

async function sizeOf() {
  const scan = await open(new Uint8Array(readFileSync(at("chest.8vo"))));
  const { size } = scan;
  scan.close();
  return { size };
}

test("the surface of a skull is that of octavo render", {
  skip: existsSync(skull) ? false : "no shared data",
}, async () => {
  const side = 128;
  const query = "?url=skull.8vo&layout=3d&mode=iso&iso=226&camera=30,15,1";
  await inPage(query, { width: 300, height: 320 }, async (page) => {
    await showRaysAlone(page, side);
    const picture = await panelPng(page, "panel-3d");
    const { level } = await page.evaluate(() => octavo.rays.fidelity());
    run("render", at("skull.8vo"), "--mode", "iso", "--isovalue", "226", "--azimuth", "30",
      "--elevation", "15", "--size", `${side}x${side}`, "--level", `${level}`, "--no-legend",
      "--no-sides", "--no-scale-bar", "-o", at("skull.png"));
    if (process.env.OCTAVO_PICTURES) {
      writeFileSync(join(process.env.OCTAVO_PICTURES, "page.png"), picture);
      writeFileSync(join(process.env.OCTAVO_PICTURES, "render.png"), readFileSync(at("skull.png")));
    }
    const rendered = pngPixels(readFileSync(at("skull.png")));
    const seen = pngPixels(picture);
    assert.deepEqual([seen.width, seen.height], [side, side]);
    // Struts of the head rest are thinner than a pixel: what one has, the other has beside it.
    const covers = [(i) => rendered.grey[i] > 24, (i) => seen.grey[i] > 32];
    const isNear = (covered, i) => {
      const [x, y] = [i % side, Math.floor(i / side)];
      for (let n = 0; n < 9; ++n) {
        const [u, v] = [x + (n % 3) - 1, y + Math.floor(n / 3) - 1];
        if (u >= 0 && v >= 0 && u < side && v < side && covered(v * side + u)) return true;
      }
      return false;
    };
    const counts = covers.map((own, k) => {
      const pixels = Array.from({ length: side * side }, (_, i) => i).filter(own);
      return [pixels.length, pixels.filter((i) => isNear(covers[1 - k], i)).length];
    });
    let [both, squares] = [0, 0];
    for (let i = 0; i < side * side; ++i) {
      if (!covers[0](i) || !covers[1](i)) continue;
      both += 1;
      squares += (rendered.grey[i] - seen.grey[i]) ** 2;
    }
    const deviation = Math.sqrt(squares / both);
    console.log(`skull: level ${level}, covered and near ${counts.join(" and ")}, ` +
      `brightness differs by ${deviation.toFixed(1)} of 255`);
    for (const [all, near] of counts) assert.ok(all > 2000 && near / all > 0.99, `${counts}`);
  });
});

test(`${flightSeconds} s of flight stay within their memory`, async () => {
  // A machine of 1 GB: fewer voxels are kept than the scan has.
  await inPage("?url=chest.8vo&mode=mip", { width: 640, height: 520 }, async (page) => {
    await settled(page);
    const limit = await page.evaluate(() => octavo.session.cells.budgetBytes);
    const { size } = await sizeOf();
    const began = performance.now();
    let [mostHeld, mostPage, steps] = [0, 0, 0];
    const early = [];
    // On a busy machine longer: until there is more than fits in half of the memory.
    const lasts = () => {
      const seconds = (performance.now() - began) / 1000;
      return seconds < flightSeconds || (mostHeld <= limit / 2 && seconds < 10 * flightSeconds);
    };
    for (; lasts(); ++steps) {
      await page.evaluate(([n, [nx, ny, nz]]) => octavo.store.set({
        at: [(n * 13) % nx, (n * 17) % ny, (n * 3) % nz],
        camera: { azimuth: ((n * 5) % 360) - 180, elevation: (n * 3) % 60, zoom: 1 + (n % 40) / 10 },
        layout: ["four", "z", "four", "x"][Math.floor(n / 25) % 4],
      }), [steps, size]);
      await page.waitForTimeout(50);
      mostHeld = Math.max(mostHeld, await page.evaluate(() => octavo.session.cells.heldBytes));
      if (steps % 10 === 0) {
        const memory = memoryOf("type=renderer");
        mostPage = Math.max(mostPage, memory);
        early.push(memory);
      }
    }
    const frames = await page.evaluate(() => octavo.stage.frames);
    const mb = (bytes) => Math.round(bytes / 1e6);
    const half = early.slice(Math.floor(early.length / 2));
    console.log(`flight: ${steps} steps, ${frames} frames, voxels ${mb(mostHeld)} of ${mb(limit)} MB, ` +
      `page ${mb(mostPage)} MB at most, ${mb(half[0])} at half time, ${mb(half.at(-1))} at the end, ` +
      `${JSON.stringify(fetched())}`);
    assert.ok(mostHeld > limit / 2 && mostHeld <= limit, `${mostHeld} of ${limit}`);
    assert.ok(mostPage > 0 && mostPage <= mostMemory, `${mostPage}`);
    assert.equal(await page.locator("#message").isVisible(), false);
  }, 1);
});
