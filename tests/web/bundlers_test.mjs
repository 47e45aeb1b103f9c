// Pages that bundlers make of @octavo/reader as npm installs it, in Chromium: each reads a scan.
//
// usage: node bundlers_test.mjs FOLDER, which tests/web/setup has filled
import assert from "node:assert/strict";
import { cpSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { pathToFileURL } from "node:url";
import { inChromium, newPage } from "./support/chromium.mjs";
import { dist, golden, root } from "./support/golden.mjs";
import { installPackage, scanName, writeApp } from "./support/package.mjs";
import { startServer } from "./support/server.mjs";

const bundlers = createRequire(join(process.argv[2], "package.json"));
const installed = (name) => import(pathToFileURL(bundlers.resolve(name)).href);

let folder;
let expected;
before(async () => {
  folder = mkdtempSync(join(tmpdir(), "octavo-bundlers-"));
  installPackage(folder);
  writeApp(join(folder, "app"));
  const { open } = await import(join(dist, "reader-node.js"));
  const scan = await open(golden(scanName));
  expected = Array.from(await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0));
});
after(() => rmSync(folder, { recursive: true, force: true }));

const app = (name = "") => join(folder, "app", name);

/** What a page says that reads the scan. */
async function saidAt(url) {
  let said;
  await inChromium(async (browser) => {
    const page = await newPage(browser, url);
    await page.waitForFunction(() => globalThis.said);
    said = await page.evaluate(() => globalThis.said);
  });
  return said;
}

/** The same of a folder that a static host serves, with the page and the scan put into it. */
async function saidOf(made, { page = true, others = [] } = {}) {
  const site = await startServer({ "/": made });
  if (page) cpSync(app("index.html"), join(made, "index.html"));
  cpSync(app(`public/${scanName}`), join(made, scanName));
  const packed = join(folder, "node_modules/@octavo/reader/dist");
  for (const name of others) cpSync(join(packed, name), join(made, name));
  try {
    return await saidAt(`${site.url}/index.html`);
  } finally {
    await site.close();
  }
}

const beside = { others: ["worker.js", "octavo.wasm"] };

const [major, minor] = process.versions.node.split(".").map(Number);

for (const vite of ["vite", "vite-8"]) {
  const isTooOld = vite === "vite-8" && (major < 20 || (major === 20 && minor < 19)) &&
    "it takes Node.js 20.19 or later";

  test(`${vite} build`, { skip: isTooOld }, async () => {
    const { build } = await installed(vite);
    const made = join(folder, `${vite}-out`);
    await build({ root: app(), base: "./", logLevel: "error", build: { outDir: made } });
    assert.ok(readdirSync(join(made, "assets")).some((name) => /^octavo.*\.wasm$/.test(name)));
    assert.deepEqual(await saidOf(made, { page: false }), expected);
  });

  test(`${vite} as a server for development`, { skip: isTooOld }, async () => {
    const { createServer } = await installed(vite);
    const server = await createServer({
      root: app(), logLevel: "error", cacheDir: join(folder, `${vite}-cache`),
      // Before version 8 it moves packages without their files.
      optimizeDeps: vite === "vite" ? { exclude: ["@octavo/reader"] } : {},
      server: { host: "127.0.0.1", port: 0, ws: false, hmr: false, fs: { allow: [folder] } } });
    await server.listen();
    try {
      const { port } = server.httpServer.address();
      assert.deepEqual(await saidAt(`http://127.0.0.1:${port}/`), expected);
    } finally {
      await server.close();
    }
  });
}

test("webpack", async () => {
  const { default: webpack } = await installed("webpack");
  const made = join(folder, "webpack-out");
  const stats = await new Promise((resolve, reject) => webpack({
    mode: "production", context: folder, entry: app("main.js"), performance: false,
    output: { path: made, filename: "main.js" },
  }, (error, all) => (error ? reject(error) : resolve(all))));
  assert.equal(stats.toString({ all: false, errors: true, warnings: true }), "");
  assert.deepEqual(await saidOf(made), expected);
});

test("rollup, with worker.js and octavo.wasm copied beside what it makes", async () => {
  const { rollup } = await installed("rollup");
  const { default: resolve } = await installed("@rollup/plugin-node-resolve");
  const made = join(folder, "rollup-out");
  const bundle = await rollup({
    input: app("main.js"), plugins: [resolve({ browser: true })],
    onwarn: (warning) => assert.fail(warning.message) });
  await bundle.write({ dir: made, format: "es" });
  assert.deepEqual(await saidOf(made, beside), expected);
});

test("esbuild, with worker.js and octavo.wasm copied beside what it makes", async () => {
  const { build } = createRequire(join(root, "web/package.json"))("esbuild");
  const made = join(folder, "esbuild-out");
  const { warnings } = await build({
    entryPoints: [app("main.js")], bundle: true, format: "esm", minify: true, outdir: made });
  assert.deepEqual(warnings, []);
  // Without them the page is told which file is not there.
  assert.match(await saidOf(made), /^io: octavo\.wasm: .*404: http.*\/octavo\.wasm$/);
  assert.match(await saidOf(made, { others: ["octavo.wasm"] }),
    /^io: small-int16\.8vo: .*http.*\/worker\.js$/);
  assert.deepEqual(await saidOf(made, beside), expected);
});
