// @octavo/reader as npm packs and installs it, away from this repository: types, Node.js, a bundle.
//
// usage: node tests/web/package_test.mjs
import assert from "node:assert/strict";
import { execFileSync, spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { golden, root } from "./support/golden.mjs";
import { installPackage, scanName, writeApp } from "./support/package.mjs";

const tools = createRequire(join(root, "web/package.json"));

let folder;
before(() => {
  folder = mkdtempSync(join(tmpdir(), "octavo-package-"));
  installPackage(folder);
});
after(() => rmSync(folder, { recursive: true, force: true }));

test("its license comes with it", () => {
  const own = (name) => readFileSync(join(folder, "node_modules/@octavo/reader", name), "utf8");
  assert.equal(own("LICENSE"), readFileSync(join(root, "LICENSE"), "utf8"));
});

const program = `
import { createPool, open, OctavoError, type ErrorKind, type Volume } from "@octavo/reader";
import { loadBytes, loadNifti } from "@octavo/reader/niivue";

const pool = await createPool({ workers: 1, wasm: new URL("https://example.org/octavo.wasm") });
const scan: Volume = await open(new Uint8Array(8), { pool, credentials: "include" });
const voxels = await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);
export const nifti: ArrayBuffer = await loadNifti("scan.8vo", { level: voxels.length });
export const same: Promise<ArrayBuffer> = loadBytes(nifti);
export const kind: ErrorKind = new OctavoError("io", "why").kind;
// @ts-expect-error: no worker is made of a number
await createPool({ worker: 5 });
// @ts-expect-error: a box has two ends
await scan.read({ lo: [0, 0, 0] }, 0);
`;

test("programs under strict TypeScript know its types", () => {
  const ts = tools("typescript");
  const path = join(folder, "program.ts");
  const inBrowsers = "await createPool({ wasm: new WebAssembly.Module(nifti) });\n";
  for (const [module, moduleResolution, hasDom] of [
    ["NodeNext", "NodeNext", true], ["ESNext", "Bundler", true], ["Node16", "Node16", false]]) {
    writeFileSync(path, hasDom ? program + inBrowsers : program);
    const made = ts.createProgram([path], {
      target: ts.ScriptTarget.ES2022, module: ts.ModuleKind[module],
      moduleResolution: ts.ModuleResolutionKind[moduleResolution], strict: true,
      exactOptionalPropertyTypes: true, noEmit: true, skipDefaultLibCheck: true,
      lib: hasDom ? ["lib.es2022.d.ts", "lib.dom.d.ts"] : ["lib.es2022.d.ts"],
      types: hasDom ? [] : ["node"], typeRoots: [join(root, "web/node_modules/@types")],
    });
    const said = ts.getPreEmitDiagnostics(made).map(({ messageText, file }) =>
      `${file?.fileName}: ${ts.flattenDiagnosticMessageText(messageText, " ")}`);
    assert.deepEqual(said, [], `${moduleResolution} ${hasDom ? "with" : "without"} DOM`);
  }
});

test("Node.js reads a scan through it", () => {
  writeFileSync(join(folder, scanName), golden(scanName));
  writeFileSync(join(folder, "read.mjs"), `
    import { readFileSync } from "node:fs";
    import { open } from "@octavo/reader";
    import { loadNifti } from "@octavo/reader/niivue";
    const bytes = readFileSync("${scanName}");
    const scan = await open(bytes);
    const voxels = await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);
    const nifti = await loadNifti(bytes);
    console.log(voxels.constructor.name, nifti.byteLength - voxels.byteLength);
    console.log(import.meta.resolve?.("@octavo/reader/worker.js") ?? "worker-node.js");
  `);
  const said = execFileSync(process.execPath, ["read.mjs"], { cwd: folder, encoding: "utf8" });
  assert.match(said, /^Int16Array 352\n.*worker-node\.js\n$/);
});

test("programs of Node.js end by themselves, whatever they read", () => {
  const opened = `const scan = await open(readFileSync("${scanName}"));`;
  writeFileSync(join(folder, scanName), golden(scanName));
  for (const program of [
    opened,
    `${opened} scan.close();`,
    "await open(new Uint8Array(8)).catch(() => {});",
    "await createPool({ workers: 2 });",
    `${opened} await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);`,
  ]) {
    const text = `import { readFileSync } from "node:fs";
      import { createPool, open } from "@octavo/reader"; ${program} console.log("done");`;
    writeFileSync(join(folder, "ends.mjs"), text);
    // Only a program that hangs is stopped.
    const { status, signal, stdout, stderr } = spawnSync(process.execPath, ["ends.mjs"],
      { cwd: folder, encoding: "utf8", timeout: 60_000 });
    assert.deepEqual([status, signal, stdout], [0, null, "done\n"], `${program} ${stderr}`);
  }
});

test("a bundle for browsers asks for nothing of Node.js", async () => {
  writeApp(join(folder, "app"));
  const { outputFiles: [made], warnings } = await tools("esbuild").build({
    entryPoints: [join(folder, "app/main.js")], bundle: true, format: "esm", write: false });
  assert.deepEqual(warnings, []);
  assert.doesNotMatch(made.text, /node:|node_modules\/node/);
  // The words that bundlers look for.
  assert.match(made.text, /new Worker\(\s*new URL\("\.\/worker\.js", import\.meta\.url\), \{/);
  assert.match(made.text, /new URL\("\.\/octavo\.wasm", import\.meta\.url\)/);
});
