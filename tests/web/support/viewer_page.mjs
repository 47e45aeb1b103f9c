// The page of the viewer in Chromium, over files of the program.
import assert from "node:assert/strict";
import { join } from "node:path";
import { readFileSync, writeFileSync } from "node:fs";
import { inChromium, newPage } from "./chromium.mjs";
import { inFolder, root, run } from "./golden.mjs";
import { pngPixels } from "./png.mjs";
import { startServer } from "./server.mjs";

const page = join(root, "web/viewer/dist");
export const HOSTILE = "<img/src=x/onerror=document.title='taken'>";

let host;
let files;

/** Files of a phantom: a scan in which slices differ, and labels with names that are markup. */
function madeFiles() {
  return inFolder((folder) => {
    const at = (name) => join(folder, name);
    const [nx, ny, nz] = [150, 130, 90];
    const voxels = new Int16Array(nx * ny * nz);
    for (let z = 0, i = 0; z < nz; ++z) {
      for (let y = 0; y < ny; ++y) {
        for (let x = 0; x < nx; ++x, ++i) {
          const r = Math.hypot((x - 75) / 70, (y - 65) / 60, (z - 45) / 42);
          voxels[i] = r > 1 ? -1000 : r > 0.85 ? 700 + z : 3 * x - 2 * y + z;
        }
      }
    }
    writeFileSync(at("scan.raw"), voxels);
    const labels = Uint8Array.from(voxels, (v) => (v >= 700 ? 1 : v > -900 ? 2 : 0));
    writeFileSync(at("labels.raw"), labels);
    writeFileSync(at("names.txt"), `1 ${HOSTILE}\n2 inside\n`);
    const layout = (type) => ["--raw", `${nx},${ny},${nz},${type}`, "--spacing", "0.8,0.8,1.2"];
    run("build", at("scan.raw"), ...layout("int16"), "-o", at("scan.8vo"));
    run("build", at("labels.raw"), ...layout("uint8"), "--labels", "--label-names",
      at("names.txt"), "-o", at("labels.8vo"));
    run("slice", at("scan.8vo"), "--axis", "z", "--index", "40", "--window", "100,600", "--size",
      "1", "--no-scale-bar", "--no-sides", "--no-notes", "-o", at("slice.png"));
    run("render", at("scan.8vo"), "--mode", "iso", "--isovalue", "600", "--azimuth", "40",
      "--elevation", "25", "--size", "200x200", "--no-legend", "--no-sides", "--no-scale-bar",
      "-o", at("rays.png"));
    const places = Array.from({ length: 50 }, (_, i) =>
      [(i * 37) % nx, (i * 53) % ny, (i * 29) % nz]);
    const probed = JSON.parse(run(
      "probe", at("scan.8vo"), ...places.flatMap((p) => ["--at", p.join(",")]), "--json"));
    return {
      scan: readFileSync(at("scan.8vo")), labels: readFileSync(at("labels.8vo")),
      slice: pngPixels(readFileSync(at("slice.png"))),
      rays: pngPixels(readFileSync(at("rays.png"))), probed: probed.points, size: [nx, ny, nz],
    };
  });
}

/** A host of the page and the files. */
export async function startPage() {
  files = await madeFiles();
  host = await startServer({ "/": page });
  host.files.set("/favicon.ico", Buffer.alloc(0));
  host.files.set("/labels.8vo", files.labels);
  host.files.set("/files.json", Buffer.from("[]"));
  return { host, files };
}

/** A host that behaves. */
export function calm() {
  host.misbehave = null;
  host.ignoresRanges = false;
  host.headers = {};
  host.log.length = 0;
  host.files.set("/scan.8vo", files.scan);
}

/** Calls `use` with the page at an address; nothing may have been said on its console. */
export async function withPage(query, use, options = {}) {
  calm();
  options.prepare?.();
  await inChromium(async (browser) => {
    const shown = await newPage(browser, `${host.url}/index.html${query}`, {
      viewport: options.viewport ?? { width: 760, height: 560 },
    });
    await use(shown);
    if (!options.mayComplain) assert.deepEqual(shown.errors, []);
  });
}

export const settled = (shown) => shown.waitForFunction(() => {
  const { session, rays } = globalThis.octavo ?? {};
  return session?.hasPreview && !session.cells.isBusy && session.cells.missing().length === 0 &&
    (!rays.isShown || rays.isSettled);
});

/** Leaves nothing but panels, width x height pixels together, without annotations and sliders. */
export const showPanelsAlone = (shown, [width, height]) => shown.evaluate(([w, h]) => {
  document.body.classList.add("no-side");
  octavo.store.set({ hasAnnotations: false });
  const main = document.getElementById("main");
  // What stands above may end between two pixels, of which a picture would show both.
  main.style.position = "fixed";
  main.style.top = main.style.left = "0";
  main.style.width = `${w}px`;
  main.style.height = `${h}px`;
  for (const slider of document.querySelectorAll(".panel input")) slider.hidden = true;
}, [width, height]);

/** Leaves nothing but the 3-D view, side x side pixels before black. */
export async function showRaysAlone(shown, side) {
  await settled(shown);
  await showPanelsAlone(shown, [side, side]);
  await shown.evaluate(() => {
    document.documentElement.dataset.theme = "dark";
  });
}

/** The PNG of a panel once all of it is drawn. */
export async function panelPng(shown, id) {
  await shown.waitForTimeout(400);
  await settled(shown);
  await shown.waitForTimeout(200);
  return shown.locator(`#${id}`).screenshot();
}

export const text = (shown, id) => shown.locator(`#${id}`).textContent();
