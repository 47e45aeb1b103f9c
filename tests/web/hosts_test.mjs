// .8vo files in viewers of others, unchanged: on a static host neuroglancer and vizarr by the Service
// Worker that answers for zarr, niivue by its loader.
//
// usage: node hosts_test.mjs FOLDER, which tests/web/setup has filled
import assert from "node:assert/strict";
import { readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { inChromium, newPage, patienceMs } from "./support/chromium.mjs";
import { builtScan, dist, golden, inFolder, run } from "./support/golden.mjs";
import { startServer } from "./support/server.mjs";

const folder = process.argv[2];
const size = [128, 96, 80];
const bright = 900;
/** Bright where y and z are small: no turn and no mirror image looks the same. */
const isBright = ([x, y, z]) => x < 100 && y < 40 && z < 30;

let site;
let scan;
before(async () => {
  scan = await builtScan(1, (place) => (isBright(place) ? bright : 0));
  site = await startServer({
    "/dist/": dist,
    "/v/scan/": join(folder, "neuroglancer/static/client"),
    "/vizarr/": join(folder, "vizarr"),
    "/niivue/": join(folder, "node_modules/@niivue/niivue/dist"),
  });
  for (const name of ["zarr-worker.js", "octavo.wasm"]) {
    site.files.set(`/${name}`, readFileSync(join(dist, name)));
  }
  site.files.set("/scan.8vo", Buffer.from(scan.bytes));
  site.files.set("/favicon.ico", Buffer.alloc(0));
  site.files.set("/blank.html", Buffer.from("<!doctype html><canvas id=gl></canvas>"));
});
after(() => site.close());

/** Where the bright pixels of a picture lie, in parts of its size, and how many there are. */
async function brightPlace(browser, picture) {
  const page = await newPage(browser, `${site.url}/blank.html`);
  const place = await page.evaluate(async (url) => {
    const image = await createImageBitmap(await (await fetch(url)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height);
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0);
    const { data } = context.getImageData(0, 0, image.width, image.height);
    let [x, y, count] = [0, 0, 0];
    for (let i = 0; i < data.length; i += 4) {
      if (Math.min(data[i], data[i + 1], data[i + 2]) < 230) continue;
      x += (i / 4) % image.width;
      y += Math.floor(i / 4 / image.width);
      count += 1;
    }
    return { x: x / count / image.width, y: y / count / image.height, count };
  }, `data:image/png;base64,${picture.toString("base64")}`);
  await page.close();
  return place;
}

async function startWorker(page) {
  await page.evaluate(async () => {
    const { serviceWorker } = navigator;
    await serviceWorker.register("/zarr-worker.js");
    await serviceWorker.ready;
    if (serviceWorker.controller) return;
    await new Promise((resolve) => serviceWorker.addEventListener("controllerchange", resolve));
  });
}

test("a Service Worker answers for a zarr hierarchy", async () => {
  await inChromium(async (browser) => {
    const page = await newPage(browser, `${site.url}/blank.html`);
    await startWorker(page);
    const said = await page.evaluate(async () => {
      const json = async (url) => (await fetch(url)).json();
      const group = await json("/scan.8vo.zarr/zarr.json");
      const [{ path }] = group.attributes.ome.multiscales[0].datasets;
      const build = `/scan.8vo.zarr/${path.split("/")[0]}`;
      const get = (key, range) => fetch(`${build}/${key}`, range ? { headers: { Range: range } } : {});
      const chunk = await (await get("0/c/0/1/1")).arrayBuffer();
      const part = await get("0/c/0/0/0", "bytes=2-5");
      const keys = ["0/c/9/0/0", "99/zarr.json", ".zattrs", "0/c/00/0/0", "0/c/1e0/0/0", "00/zarr.json",
        "0/c/0/0", "0/c/0/0/0/0", "0/c/0/0/0x0", "0/c/ 0/0/0", "0/c/-0/0/0", "0/c//0/0", "", "0"];
      const missing = await Promise.all(keys.map(async (key) => (await get(key)).status));
      const others = ["none.8vo.zarr/zarr.json", "scan.8vo.zarr/0/zarr.json", "scan.8vo.zarr/.zgroup"];
      for (const other of others) missing.push((await fetch(`/${other}`)).status);
      return {
        group, inner: await json(`${build}/zarr.json`), array: await json(`${build}/0/zarr.json`),
        chunk: Array.from(new Int16Array(chunk)),
        part: [part.status, (await part.arrayBuffer()).byteLength], missing,
      };
    });
    assert.deepEqual(said.array.shape, [...size].reverse());
    assert.equal(said.array.data_type, "int16");
    const [{ datasets }] = said.group.attributes.ome.multiscales;
    assert.deepEqual(datasets[1].coordinateTransformations, [
      { type: "scale", scale: [1, 1, 1] },
      { type: "translation", translation: [30.25, -19.75, 10.25] }]);
    const [inner] = said.inner.attributes.ome.multiscales;
    assert.deepEqual(
      inner.datasets, datasets.map((one) => ({ ...one, path: one.path.split("/")[1] })));
    assert.deepEqual(said.part, [206, 4]);
    assert.deepEqual(said.missing, said.missing.map(() => 404));
    const [depth, height, width] = said.array.chunk_grid.configuration.chunk_shape;
    for (let z = 0; z < depth; z += 5) {
      for (let y = 0; y < height; y += 3) {
        for (let x = 0; x < width; x += 7) {
          const place = [x + width, y + height, z];
          const isInside = place.every((at, axis) => at < size[axis]);
          const voxel = isInside
            ? scan.voxels[(place[2] * size[1] + place[1]) * size[0] + place[0]] : 0;
          assert.equal(said.chunk[(z * height + y) * width + x], voxel);
        }
      }
    }
  });
});

/** A scan that lies oblique, and the levels that the program writes of it as OME-Zarr. */
function obliqueScan() {
  return inFolder((at) => {
    writeFileSync(join(at, "scan.raw"), Uint8Array.from({ length: 90 * 70 * 40 }, (_, i) => i % 251));
    const [c, s] = [Math.cos(0.4), Math.sin(0.4)];
    writeFileSync(join(at, "scan.mhd"), [
      "ObjectType = Image", "NDims = 3", "DimSize = 90 70 40", "ElementType = MET_UCHAR",
      "ElementSpacing = 0.5 0.75 2", `TransformMatrix = ${c} ${s} 0 0 0 -1 ${-s} ${c} 0`,
      "Offset = 3 -2 1", "ElementByteOrderMSB = False", "ElementDataFile = scan.raw", ""].join("\n"));
    run("build", join(at, "scan.mhd"), "-o", join(at, "scan.8vo"));
    run("export", join(at, "scan.8vo"), "-o", join(at, "scan.ome.zarr"));
    const group = JSON.parse(readFileSync(join(at, "scan.ome.zarr/zarr.json"), "utf8"));
    return { bytes: readFileSync(join(at, "scan.8vo")), image: group.attributes.ome.multiscales[0] };
  });
}

test("a zarr hierarchy stands where the exported one does", async () => {
  const { bytes, image } = await obliqueScan();
  site.files.set("/oblique.8vo", bytes);
  const own = await inChromium(async (browser) => {
    const page = await newPage(browser, `${site.url}/blank.html`);
    await startWorker(page);
    return page.evaluate(async () => (await fetch("/oblique.8vo.zarr/zarr.json")).json());
  });
  const [{ axes, datasets }] = own.attributes.ome.multiscales;
  assert.deepEqual(axes, image.axes);
  const places = (all) => all.flatMap(({ coordinateTransformations: [{ scale }, { translation }] }) =>
    [...scale, ...translation]);
  assert.ok(datasets.length > 1);
  const exported = places(image.datasets);
  places(datasets).forEach((at, i) => assert.ok(Math.abs(at - exported[i]) < 1e-9));
});

test("chunks of a file that took another one's place are none of the old hierarchy", async () => {
  const shorter = golden("small-int16.8vo");
  for (const next of [Buffer.from((await builtScan(2)).bytes), Buffer.from(shorter)]) {
    await inChromium(async (browser) => {
      site.files.set("/one.8vo", Buffer.from((await builtScan(1)).bytes));
      for (let i = 0; i < 5; ++i) site.files.set(`/other${i}.8vo`, Buffer.from(shorter));
      const page = await newPage(browser, `${site.url}/blank.html`);
      await startWorker(page);
      const get = (url) => page.evaluate(async (at) => {
        const answer = await fetch(at);
        const bytes = new Uint8Array(await answer.arrayBuffer());
        return [answer.status, bytes.length < 5000 ? new TextDecoder().decode(bytes) : ""];
      }, url);
      const firstPath = async () => {
        const [, text] = await get("/one.8vo.zarr/zarr.json");
        return JSON.parse(text).attributes.ome.multiscales[0].datasets[0].path;
      };
      const old = await firstPath();
      assert.equal((await get(`/one.8vo.zarr/${old}/c/0/0/0`))[0], 200);
      site.files.set("/one.8vo", next);
      const late = await get(`/one.8vo.zarr/${old}/c/1/1/1`);
      assert.equal(late[0], 409);
      assert.match(late[1], /one\.8vo: another file stands there now; read zarr\.json anew/);
      // As after a pause, when nothing is known any more.
      for (let i = 0; i < 5; ++i) await get(`/other${i}.8vo.zarr/zarr.json`);
      for (const key of ["zarr.json", "c/0/0/0"]) {
        assert.equal((await get(`/one.8vo.zarr/${old}/${key}`))[0], 409);
      }
      const now = await firstPath();
      assert.notEqual(now, old);
      assert.equal((await get(`/one.8vo.zarr/${now}/c/0/0/0`))[0], 200);
      // Whoever asks for zarr.json anew gets the file that stands there, noticed or not.
      site.files.set("/one.8vo", Buffer.from((await builtScan(1)).bytes));
      assert.equal(await firstPath(), old);
    });
  }
});

/** Where the bright part of a scan is, from when a page shows more than `least` pixels of it on;
 *  undefined where there is nothing bright after all patience. */
async function whenBright(browser, page, least) {
  const end = Date.now() + patienceMs;
  while (Date.now() < end) {
    // Two pictures later: a page that has much to do is left to do it.
    await page.evaluate(() => new Promise((resolve) => {
      requestAnimationFrame(() => requestAnimationFrame(resolve));
    }));
    await page.waitForTimeout(500);
    const canvas = page.locator("canvas").first();
    if ((await canvas.count()) === 0) continue;
    const place = await brightPlace(browser, await canvas.screenshot());
    if (place.count > least) return place;
  }
  return undefined;
}

/**
 * Where neuroglancer shows the bright part of a scan.
 * source   as its users type it
 * prepare  called with a page of the site before
 */
async function shownByNeuroglancer(source, prepare) {
  const state = {
    layers: [{
      type: "image", name: "scan", source,
      shaderControls: { normalized: { range: [0, bright] } },
    }],
    layout: "xy", showAxisLines: false, showScaleBar: false, showDefaultAnnotations: false,
    crossSectionBackgroundColor: "#000000",
  };
  // What its Python server would say.
  site.misbehave = (request, response, entry) => {
    if (entry.path.startsWith("/events/")) {
      response.writeHead(200, { "Content-Type": "text/event-stream" });
      for (const [k, s] of [["c", {}], ["s", state]]) {
        response.write(`data: ${JSON.stringify({ k, g: "a/1", s })}\n\n`);
      }
      return true;
    }
    if (request.method !== "POST") return false;
    response.writeHead(200, { "Content-Type": "application/json" }).end("{}");
    return true;
  };
  let place;
  await inChromium(async (browser) => {
    const context = await browser.newContext({ viewport: { width: 700, height: 560 } });
    context.setDefaultTimeout(patienceMs);
    const page = await context.newPage();
    await page.goto(`${site.url}/blank.html`);
    await prepare(page);
    await page.goto(`${site.url}/v/scan/index.html`);
    place = await whenBright(browser, page, 2000);
  });
  site.misbehave = null;
  return place;
}

/** The first axis, z, goes to the right, y down. */
function expectRightWayAround(place) {
  assert.ok(place, "nothing bright is shown");
  assert.ok(place.x < 0.5 && place.y < 0.5, JSON.stringify(place));
}

test("neuroglancer shows a scan, the right way around", async () => {
  expectRightWayAround(await shownByNeuroglancer(`zarr3://${site.url}/scan.8vo.zarr/`, startWorker));
  assert.ok(site.log.every(({ path, range }) => path !== "/scan.8vo" || range !== ""));
});

test("vizarr shows a scan, the right way around", async () => {
  // What Galaxy would say, whose page it is built for.
  const config = { visualization_config: { dataset_id: "1" }, root: "/galaxy/" };
  site.files.set("/vizarr.html", Buffer.from(`<!doctype html><style>html, body, #app { height: 100%;
    margin: 0; background: #000 }</style><div id="app" data-incoming='${JSON.stringify(config)}'></div>
    <script type="module" src="/vizarr/index.js"></script>`));
  site.files.set("/galaxy/api/datasets/1", Buffer.from(JSON.stringify({
    id: "1", name: "scan", state: "deferred",
    sources: [{ source_uri: `${site.url}/scan.8vo.zarr` }],
  })));
  site.log.length = 0;
  await inChromium(async (browser) => {
    const context = await browser.newContext({ viewport: { width: 700, height: 560 } });
    // A decoder of JPEG 2000, which it fetches from elsewhere before all else.
    await context.route("https://cdn.jsdelivr.net/**", (route) => route.fulfill({
      contentType: "text/javascript", body: "export class JpxImage {}",
      headers: { "Access-Control-Allow-Origin": "*" },
    }));
    context.setDefaultTimeout(patienceMs);
    const page = await context.newPage();
    await page.goto(`${site.url}/blank.html`);
    await startWorker(page);
    await page.goto(`${site.url}/vizarr.html`);
    const place = await whenBright(browser, page, 40_000);
    assert.ok(place, "nothing bright is shown");
    // Bright to x = 100 of 128 and y = 40 of 96.
    assert.ok(place.y < 0.5, JSON.stringify(place));
  });
  assert.ok(site.log.every(({ path, range }) => path !== "/scan.8vo" || range !== ""));
});

test("niivue shows a scan, voxels at their places", async () => {
  await inChromium(async (browser) => {
    const page = await browser.newPage({ viewport: { width: 700, height: 560 } });
    page.setDefaultTimeout(patienceMs);
    await page.goto(`${site.url}/blank.html`);
    const said = await page.evaluate(async () => {
      const { Niivue } = await import("/niivue/index.js");
      const { loadBytes, loadNifti } = await import("/dist/niivue.js");
      const viewer = new Niivue();
      await viewer.attachTo("gl");
      await viewer.loadFromArrayBuffer(await loadNifti("/scan.8vo"), "scan.nii");
      const [volume] = viewer.volumes;
      const shown = viewer.volumes.length;
      viewer.useLoader(loadBytes, "8vo", "nii");
      await viewer.addVolumesFromUrl([{ url: "/scan.8vo" }]);
      return {
        shown,
        dims: volume.hdr.dims.slice(0, 4), affine: volume.hdr.affine, max: volume.global_max,
        // In RAS order: both index axes x and y are turned around.
        corner: volume.getValue(127, 95, 0), far: volume.getValue(0, 0, 79),
        count: viewer.volumes.length, other: viewer.volumes[1]?.global_max,
      };
    });
    assert.deepEqual(said.dims, [3, ...size]);
    assert.deepEqual(said.affine.map((row) => row.map((n) => n + 0)),
      [[-0.5, 0, 0, -10], [0, -0.5, 0, 20], [0, 0, 0.5, 30], [0, 0, 0, 1]]);
    assert.equal(said.max, bright);
    assert.deepEqual([said.corner, said.far], [bright, 0]);
    assert.deepEqual([said.shown, said.count, said.other], [1, 2, bright]);
    assert.ok(await whenBright(browser, page, 1000), "nothing bright is shown");
  });
});
