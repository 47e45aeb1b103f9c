// An .8vo file as the keys of an OME-Zarr 0.5 hierarchy (zarr v3): what viewers ask a server for.
//
//     zarr.json                the group: its levels stand at BUILD/0, BUILD/1, ...
//     BUILD/zarr.json          the same group, its levels at 0, 1, ...
//     BUILD/2/zarr.json        the array of level 2
//     BUILD/2/c/0/3/1          its chunk z 0, y 3, x 1
//
// BUILD is the build id of the file. Where another file takes its place, those who know the old
// keys get nothing of it: metadata and chunks of two files never mix.
//
// A level is an array [z][y][x] in chunks of about 64^3 samples, uncompressed and little-endian.
// Places are in mm along the axes of the volume, as `octavo export` writes them; how these lie in a
// body is not said there.
import type { Level, Vector3, Volume } from "../api.js";
import { OctavoError } from "../errors.js";
import { cellSideOf } from "../volume/cells.js";

/** The status of an error about a key that is one of another file. */
export const otherFile = 409;

/**
 * The bytes of a key; null where there is none.
 * Rejects with kind replaced where another file has taken the place of `scan`, and with that status
 * where it is the key that is one of another.
 */
export async function valueOf(
  scan: Volume, key: string, signal?: AbortSignal): Promise<Uint8Array<ArrayBuffer> | null> {
  if (key === "zarr.json") return jsonBytes(groupOf(scan, `${scan.buildId}/`));
  const [build, ...parts] = key.split("/") as [string, ...string[]];
  if (build !== scan.buildId) {
    if (!/^[0-9a-f]{16}$/.test(build)) return null;
    throw new OctavoError("replaced",
      `${scan.name}: another file stands there now; read zarr.json anew`, { status: otherFile });
  }
  if (parts.join("/") === "zarr.json") return jsonBytes(groupOf(scan, ""));
  const level = scan.levels[numberOf(parts[0]!)];
  if (!level) return null;
  if (parts.length === 2 && parts[1] === "zarr.json") return jsonBytes(arrayOf(scan, level));
  const place = parts.slice(2).map(numberOf);
  if (parts[1] !== "c" || place.length !== 3 || place.some(Number.isNaN)) return null;
  return chunkAt(scan, level, [place[2]!, place[1]!, place[0]!], signal);
}

/** Of digits alone, as keys have them; else NaN. */
const numberOf = (text: string): number => (/^(0|[1-9]\d*)$/.test(text) ? Number(text) : NaN);

const zyx = <T>(v: readonly T[]): T[] => [v[2]!, v[1]!, v[0]!];

const jsonBytes = (value: unknown): Uint8Array<ArrayBuffer> =>
  new TextEncoder().encode(JSON.stringify(value));

/** Down to the level that is one chunk: coarser ones reach far beyond the end of the volume. */
function shownLevels(scan: Volume): readonly Level[] {
  const isChunk = (level: Level) =>
    level.size.every((size, axis) => size <= cellSideOf(level)[axis]!);
  return scan.levels.slice(0, scan.levels.findIndex(isChunk) + 1);
}

/** A world position along the axes of the volume. */
const alongAxes = (scan: Volume, world: Vector3): number[] => [0, 1, 2].map((axis) =>
  world.reduce((sum, at, row) => sum + scan.direction[3 * row + axis]! * at, 0));

function groupOf(scan: Volume, before: string): unknown {
  const datasets = shownLevels(scan).map((level) => ({
    path: `${before}${level.level}`,
    coordinateTransformations: [
      { type: "scale", scale: zyx(level.spacingMm) },
      { type: "translation", translation: zyx(alongAxes(scan, level.originMm)) },
    ],
  }));
  const axes = ["z", "y", "x"].map((name) => ({ name, type: "space", unit: "millimeter" }));
  return {
    zarr_format: 3,
    node_type: "group",
    attributes: { ome: { version: "0.5", multiscales: [{ name: scan.name, axes, datasets }] } },
  };
}

function arrayOf(scan: Volume, level: Level): unknown {
  return {
    zarr_format: 3,
    node_type: "array",
    shape: zyx(level.size),
    data_type: scan.type,
    chunk_grid: {
      name: "regular", configuration: { chunk_shape: zyx(cellSideOf(level)) } },
    chunk_key_encoding: { name: "default", configuration: { separator: "/" } },
    fill_value: 0,
    codecs: [{ name: "bytes", configuration: { endian: "little" } }],
    attributes: {},
    dimension_names: ["z", "y", "x"],
  };
}

/** A whole chunk; beyond the end of the volume it holds zeros. */
async function chunkAt(
  scan: Volume, level: Level, place: Vector3,
  signal?: AbortSignal): Promise<Uint8Array<ArrayBuffer> | null> {
  const side = cellSideOf(level);
  const lo = place.map((n, axis) => n * side[axis]!) as unknown as Vector3;
  if (lo.some((at, axis) => at >= level.size[axis]!)) return null;
  const hi = lo.map((at, axis) =>
    Math.min(at + side[axis]!, level.size[axis]!)) as unknown as Vector3;
  const voxels = await scan.read({ lo, hi }, level.level, signal ? { signal } : {});
  const [width, height, depth] = [hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]];
  if (width === side[0] && height === side[1] && depth === side[2]) {
    return new Uint8Array(voxels.buffer);
  }
  const bytes = voxels.BYTES_PER_ELEMENT;
  const own = new Uint8Array(voxels.buffer);
  const chunk = new Uint8Array(side[0] * side[1] * side[2] * bytes);
  for (let z = 0; z < depth; ++z) {
    for (let y = 0; y < height; ++y) {
      const from = (z * height + y) * width * bytes;
      chunk.set(own.subarray(from, from + width * bytes), (z * side[1] + y) * side[0] * bytes);
    }
  }
  return chunk;
}
