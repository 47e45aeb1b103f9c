// An .8vo file as the keys of an OME-Zarr 0.5 hierarchy (zarr v3): what viewers ask a server for.
//
// A level is an array [z][y][x] in chunks of about 64^3 samples, uncompressed and little-endian.
// Sizes are in mm along the axes of the volume; how these lie in a body is not said there.
import type { Level, Vector3, Volume } from "../api.js";
import { cellSideOf } from "../volume/cells.js";

/** The bytes of a key; null where there is none. */
export async function valueOf(
  scan: Volume, key: string, signal?: AbortSignal): Promise<Uint8Array<ArrayBuffer> | null> {
  const parts = key.split("/");
  if (key === "zarr.json") return jsonBytes(groupOf(scan));
  const level = /^\d+$/.test(parts[0]!) ? scan.levels[Number(parts[0])] : undefined;
  if (!level) return null;
  if (parts.length === 2 && parts[1] === "zarr.json") return jsonBytes(arrayOf(scan, level));
  const place = parts.slice(2).map(Number);
  if (parts[1] !== "c" || place.length !== 3 || !place.every(isPlace)) return null;
  return chunkAt(scan, level, [place[2]!, place[1]!, place[0]!], signal);
}

const isPlace = (n: number): boolean => Number.isInteger(n) && n >= 0;

const zyx = <T>(v: readonly T[]): T[] => [v[2]!, v[1]!, v[0]!];

const jsonBytes = (value: unknown): Uint8Array<ArrayBuffer> =>
  new TextEncoder().encode(JSON.stringify(value));

/** Down to the level that is one chunk: coarser ones reach far beyond the end of the volume. */
function shownLevels(scan: Volume): readonly Level[] {
  const isChunk = (level: Level) =>
    level.size.every((size, axis) => size <= cellSideOf(level)[axis]!);
  return scan.levels.slice(0, scan.levels.findIndex(isChunk) + 1);
}

function groupOf(scan: Volume): unknown {
  const datasets = shownLevels(scan).map((level) => ({
    path: String(level.level),
    coordinateTransformations: [
      { type: "scale", scale: zyx(level.spacingMm) },
      // Samples stand at the centers of the voxels that they stand for.
      {
        type: "translation",
        translation: zyx(level.factor.map((n, axis) => ((n - 1) / 2) * scan.spacingMm[axis]!)),
      },
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
