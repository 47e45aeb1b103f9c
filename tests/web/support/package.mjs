// @octavo/reader as npm packs and installs it, in a folder of its own.
import { execFileSync } from "node:child_process";
import { mkdirSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { golden, root } from "./golden.mjs";

export const scanName = "small-int16.8vo";

/** Installs the package into a folder; no network is asked. */
export function installPackage(folder) {
  const npm = (where, ...words) => execFileSync("npm", words, {
    cwd: where, encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });
  npm(join(root, "web/reader"), "pack", "--silent", "--pack-destination", folder);
  const packed = readdirSync(folder).find((name) => name.endsWith(".tgz"));
  writeFileSync(join(folder, "package.json"), '{"name": "user", "type": "module"}\n');
  npm(folder, "install", "--offline", "--silent", "--no-audit", "--no-fund", join(folder, packed));
}

/** A page that reads a scan through the package: index.html, main.js and the scan in `folder`. */
export function writeApp(folder) {
  mkdirSync(folder, { recursive: true });
  writeFileSync(join(folder, "index.html"),
    '<!doctype html><title>app</title><script type="module" src="./main.js"></script>\n');
  writeFileSync(join(folder, "main.js"), `
    import { open } from "@octavo/reader";
    open("${scanName}").then(async (scan) => {
      const voxels = await scan.read({ lo: [0, 0, 0], hi: scan.size }, 0);
      globalThis.said = Array.from(voxels);
    }).catch((error) => { globalThis.said = error.kind + ": " + error.message; });
  `);
  mkdirSync(join(folder, "public"), { recursive: true });
  writeFileSync(join(folder, "public", scanName), golden(scanName));
}
