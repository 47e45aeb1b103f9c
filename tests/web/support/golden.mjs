// The golden files, and what the library makes of every level of them.
import { execFileSync } from "node:child_process";
import { createHash } from "node:crypto";
import { mkdtempSync, readdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";

export const root = fileURLToPath(new URL("../../../", import.meta.url));
export const goldenFolder = join(root, "tests/golden/v1");
export const dist = join(root, "web/reader/dist");
export const program = process.env.OCTAVO ?? join(root, "build/octavo");

export const sha1 = (bytes) => createHash("sha1").update(bytes).digest("hex");
export const goldenNames = () =>
  readdirSync(goldenFolder).filter((name) => name.endsWith(".8vo")).sort();
export const golden = (name) => new Uint8Array(readFileSync(join(goldenFolder, name)));

export const run = (...words) =>
  execFileSync(program, words, { encoding: "utf8", stdio: ["ignore", "pipe", "pipe"] });

/** Calls `use` with a folder that is gone afterwards. */
export async function inFolder(use) {
  const folder = mkdtempSync(join(tmpdir(), "octavo-web-"));
  try {
    return await use(folder);
  } finally {
    rmSync(folder, { recursive: true, force: true });
  }
}

/** The bytes of the file that the program makes of voxels of 1 mm, x fastest. */
export function builtRaw(voxels, size) {
  return inFolder((folder) => {
    const type = voxels.constructor.name.replace("Array", "").toLowerCase();
    writeFileSync(join(folder, "v.raw"), voxels);
    run("build", join(folder, "v.raw"), "--raw", `${size},${type}`, "--spacing", "1", "-o",
      join(folder, "v.8vo"));
    return readFileSync(join(folder, "v.8vo"));
  });
}

/**
 * A scan of 128 x 96 x 80 voxels of 0.5 mm: the bytes of its file, and its voxels.
 * voxelOf  of [x, y, z]; noise over a ramp where absent: more than a reader asks for at first
 */
export function builtScan(seed, voxelOf) {
  return inFolder((folder) => {
    const [width, height, depth] = [128, 96, 80];
    let state = seed;
    const voxels = Int16Array.from({ length: width * height * depth }, (_, i) => {
      state = (state * 48271) % 2147483647;
      const place = [i % width, Math.floor(i / width) % height, Math.floor(i / width / height)];
      return voxelOf ? voxelOf(place) : place[0] * 4 + (state % 200) - 300;
    });
    writeFileSync(join(folder, "scan.raw"), voxels);
    writeFileSync(join(folder, "scan.mhd"), [
      "ObjectType = Image", "NDims = 3", `DimSize = ${width} ${height} ${depth}`,
      "ElementType = MET_SHORT", "ElementSpacing = 0.5 0.5 0.5",
      "TransformMatrix = 1 0 0 0 1 0 0 0 1", "Offset = 10 -20 30", "ElementByteOrderMSB = False",
      "ElementDataFile = scan.raw", ""].join("\n"));
    run("build", join(folder, "scan.mhd"), "-o", join(folder, "scan.8vo"));
    return { bytes: new Uint8Array(readFileSync(join(folder, "scan.8vo"))), voxels };
  });
}

/** The NIfTI file that the program makes of a level of a file. */
export function exportedNifti(bytes, level) {
  return inFolder((folder) => {
    const [scan, nifti] = [join(folder, "scan.8vo"), join(folder, "level.nii")];
    writeFileSync(scan, bytes);
    run("extract", scan, "--level", String(level), "--stored", "-o", nifti);
    const written = readFileSync(nifti);
    return new DataView(written.buffer, written.byteOffset, written.byteLength);
  });
}

const table = Uint32Array.from({ length: 256 }, (_, byte) => {
  let value = byte;
  for (let bit = 0; bit < 8; ++bit) value = value & 1 ? 0x82f63b78 ^ (value >>> 1) : value >>> 1;
  return value;
});

export function crc32c(bytes) {
  let value = ~0;
  for (const byte of bytes) value = table[(value ^ byte) & 255] ^ (value >>> 8);
  return ~value >>> 0;
}

/** Those of levels.txt, which tests of the library hold true: {name: [of level 0, ...]} */
export function listedChecksums() {
  const checksums = {};
  for (const line of readFileSync(join(goldenFolder, "levels.txt"), "utf8").trim().split("\n")) {
    const [name, level, value] = line.split(/\s+/);
    (checksums[name] ??= [])[Number(level)] = Number.parseInt(value, 16);
  }
  return checksums;
}

/** SHA-1 as the program extracts them: {name: [of level 0, of level 1, ...]} */
export function programDigests() {
  return inFolder((folder) => {
    const digests = {};
    for (const name of goldenNames()) {
      const path = join(goldenFolder, name);
      const count = JSON.parse(run("info", path, "--json")).levels.length;
      digests[name] = Array.from({ length: count }, (_, level) => {
        const raw = join(folder, "level.raw");
        run("extract", path, "--level", String(level), "--stored", "--force", "-o", raw);
        return sha1(readFileSync(raw));
      });
    }
    return digests;
  });
}
