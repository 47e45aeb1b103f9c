// Bundles the package into dist/, beside octavo.wasm of build-web: node build.mjs [WASM]
//
//   reader.js, niivue.js, worker.js                  for browsers
//   reader-node.js, niivue-node.js, worker-node.js   for Node.js
//   zarr-worker.js                                   a Service Worker
import { copyFile, mkdir, readdir, readFile, rm } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));

await mkdir(here("dist"), { recursive: true });
for (const name of await readdir(here("dist"))) {
  if (name.endsWith(".js")) await rm(here(`dist/${name}`));
}
// The bytes of a file as text, and less around it than esbuild's own loader for browsers that lack
// Uint8Array.fromBase64.
const scans = {
  name: "scans",
  setup: ({ onLoad }) => onLoad({ filter: /\.8vo$/ }, async ({ path }) => {
    const text = (await readFile(path)).toString("base64");
    return { contents: `export default Uint8Array.from(atob("${text}"), (c) => c.charCodeAt());` };
  }),
};
const settings = {
  outdir: here("dist"),
  bundle: true,
  target: "es2022",
  // Members that a constructor sets are declared by that.
  tsconfigRaw: { compilerOptions: { useDefineForClassFields: false } },
  minify: true,
  legalComments: "none",
  plugins: [scans],
  logLevel: "warning",
};
const forNode = {
  ...settings,
  target: "node18",
  external: ["node:*"],
  entryNames: "[name]-node",
  plugins: [scans, {
    name: "platform",
    setup: ({ onResolve }) =>
      onResolve({ filter: /\/platform\/browser\.js$/ }, () => ({ path: here("src/platform/node.ts") })),
  }],
};
// What both entries share stands in a file of its own, so that there is one shared pool.
const entries = {
  format: "esm",
  splitting: true,
  chunkNames: "shared-[hash]",
  entryPoints: { reader: here("src/index.ts"), niivue: here("src/hosts/niivue.ts") },
};
const worker = (platform) =>
  ({ format: "esm", entryPoints: { worker: here(`src/platform/${platform}_worker.ts`) } });
await build({ ...settings, ...entries });
await build({ ...settings, ...worker("browser") });
await build({ ...forNode, ...entries });
await build({ ...forNode, ...worker("node") });
// Not all browsers take a Service Worker that is a module; a script says where octavo.wasm is.
await build({
  ...settings,
  format: "iife",
  logOverride: { "empty-import-meta": "silent" },
  entryPoints: { "zarr-worker": here("src/hosts/zarr_worker.ts") },
});
await copyFile(
  process.argv[2] ?? here("../../build-web/web/reader/wasm/octavo.wasm"), here("dist/octavo.wasm"));
