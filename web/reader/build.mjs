// Bundles the package into dist/, beside octavo.wasm of build-web.
import { copyFile, mkdir } from "node:fs/promises";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = (path) => fileURLToPath(new URL(path, import.meta.url));

await mkdir(here("dist"), { recursive: true });
await build({
  entryPoints: {
    reader: here("src/index.ts"),
    worker: here("src/decode/worker.ts"),
  },
  outdir: here("dist"),
  bundle: true,
  format: "esm",
  target: "es2022",
  minify: true,
  sourcemap: false,
  legalComments: "none",
  external: ["node:*"],
  loader: { ".8vo": "binary" },
  logLevel: "warning",
});
await copyFile(
  process.argv[2] ?? here("../../build-web/web/reader/wasm/octavo.wasm"), here("dist/octavo.wasm"));
