// Builds the page: node build.mjs [--out FOLDER] [--tests]
//
//   dist/        index.html, style.css, viewer.js, and what the reader brings: worker and wasm
//   dist/tests/, dist/made_up/
//                with --tests: the tests as scripts that node runs; the page over a volume that is
//                made up
import { build } from "esbuild";
import { cp, mkdir, readFile, readdir, rm } from "node:fs/promises";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { privateNames } from "./private_names.mjs";

const here = dirname(fileURLToPath(import.meta.url));
const argument = (name) => {
  const at = process.argv.indexOf(name);
  return at < 0 ? undefined : process.argv[at + 1];
};
const out = resolve(here, argument("--out") ?? "dist");

const common = {
  bundle: true,
  format: "esm",
  target: "es2022",
  logLevel: "warning",
  // What the reader asks of Node.js, and the tiny volume that it warms its workers with.
  external: ["node:*"],
  loader: { ".8vo": "binary" },
  // Members that a constructor sets are declared by that.
  tsconfigRaw: { compilerOptions: { useDefineForClassFields: false } },
  absWorkingDir: here,
};

// Shaders are text to esbuild: their comments, indentation, spaces around signs and ends of lines,
// like those around them, end here.
const lean = {
  name: "lean",
  setup: ({ onLoad }) =>
    onLoad({ filter: /view[/\\](\w+_painter|\w+_shader)\.ts$/ }, async ({ path }) => {
      const text = (await readFile(path, "utf8")).replace(/^ +| *\/\/ .*$/gm, "");
      const signs = text.replace(/ ?([-=+*/<>?:&|,;{}()]+) ?/g, "$1");
      return { contents: signs.replace(/([;{,])\n+/g, "$1"), loader: "ts" };
    }),
};

async function page(entry, to) {
  await mkdir(to, { recursive: true });
  await build({
    ...common,
    entryPoints: { viewer: entry },
    outdir: to,
    minify: true,
    legalComments: "none",
    plugins: [lean],
    mangleProps: await privateNames([join(here, "src"), resolve(here, "../reader/src")]),
    alias: { "@octavo/reader": resolve(here, "../reader/src/index.ts") },
  });
  for (const name of ["index.html", "style.css", "HOSTING.md"])
    await cp(join(here, name), join(to, name));
}

async function tests() {
  const to = join(here, "dist/tests");
  await rm(to, { recursive: true, force: true });
  const names = (await readdir(join(here, "test"), { recursive: true })).filter((name) =>
    name.endsWith(".test.ts"),
  );
  await build({
    ...common,
    platform: "node",
    entryPoints: names.map((name) => join(here, "test", name)),
    outdir: to,
    outExtension: { ".js": ".mjs" },
  });
  await page(join(here, "test/made_up_page.ts"), join(here, "dist/made_up"));
}

if (process.argv.includes("--tests")) {
  await tests();
} else {
  await page(join(here, "src/main.ts"), out);
  for (const name of ["worker.js", "octavo.wasm"]) {
    await cp(join(here, "../reader/dist", name), join(out, name));
  }
}
