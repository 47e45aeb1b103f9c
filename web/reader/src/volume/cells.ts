// Boxes of a level as workers take them: cells of whole bricks, of about 64^3 samples each.
import type { Box, Level, Vector3, VoxelArray, VoxelArrays, VoxelTypeName } from "../api.js";
import { OctavoError } from "../errors.js";

export type Corners6 = [number, number, number, number, number, number];

const cellSide = 64;

export const cornersOf = (box: Box): Corners6 => [...box.lo, ...box.hi];

export const sizeOf = (box: Box): Vector3 =>
  [box.hi[0] - box.lo[0], box.hi[1] - box.lo[1], box.hi[2] - box.lo[2]];

export function voxelCount(box: Box): number {
  const [x, y, z] = sizeOf(box);
  return x * y * z;
}

/** Throws where there are no three numbers. Programs without types may give anything. */
export function checkVector(vector: unknown, name: string, what: string): void {
  const { length } = vector as Partial<Vector3> ?? {};
  if (length === 3 && Array.from(vector as Vector3).every((n) => typeof n === "number")) return;
  throw new OctavoError("invalid_argument", `${name}: ${what} is no [x, y, z]`);
}

/** Throws where the box is none, empty, not whole numbers or not inside `size`. */
export function checkBox(box: Box, size: Vector3, name: string, what: string): void {
  const { lo, hi }: Partial<Box> = box ?? {};
  checkVector(lo, name, "lo");
  checkVector(hi, name, "hi");
  const isInside = [0, 1, 2].every((axis) => {
    const lo = box.lo[axis]!;
    const hi = box.hi[axis]!;
    return Number.isInteger(lo) && Number.isInteger(hi) && 0 <= lo && lo < hi && hi <= size[axis]!;
  });
  if (!isInside) {
    throw new OctavoError("invalid_argument",
      `${name}: the box ${box.lo.join(",")} to ${box.hi.join(",")} is empty or not inside ` +
      `${what} of ${size.join(" x ")}`);
  }
}

/** A part of a box that one worker reads at once. */
export interface Cell {
  readonly box: Box;
  /** The same for the same bricks. */
  readonly key: number;
}

/** Samples of a cell along each axis. */
export function cellSideOf(level: Level): Vector3 {
  return level.brickSide.map(
    (side) => side * Math.max(1, Math.floor(cellSide / side))) as unknown as Vector3;
}

/** The cells that tile a box, x fastest. */
export function cellsOf(box: Box, level: Level): Cell[] {
  const side = cellSideOf(level);
  const first = [0, 1, 2].map((axis) => Math.floor(box.lo[axis]! / side[axis]!));
  const cells: Cell[] = [];
  for (let z = first[2]!; z * side[2] < box.hi[2]; ++z) {
    for (let y = first[1]!; y * side[1] < box.hi[1]; ++y) {
      for (let x = first[0]!; x * side[0] < box.hi[0]; ++x) {
        const at = [x, y, z];
        const lo = at.map((n, axis) => Math.max(box.lo[axis]!, n * side[axis]!));
        const hi = at.map((n, axis) => Math.min(box.hi[axis]!, (n + 1) * side[axis]!));
        cells.push({
          box: { lo: lo as unknown as Vector3, hi: hi as unknown as Vector3 },
          key: Math.abs(x * 73 + y * 151 + z * 283 + level.level * 7),
        });
      }
    }
  }
  return cells;
}

/** Halves of a box between two cells, along its longest axis; null where it is one cell. */
export function halvesOf(box: Box, level: Level): [Box, Box] | null {
  const side = cellSideOf(level);
  const firsts = [0, 1, 2].map((axis) => Math.floor(box.lo[axis]! / side[axis]!));
  const counts = [0, 1, 2].map((axis) =>
    Math.ceil(box.hi[axis]! / side[axis]!) - firsts[axis]!);
  const axis = counts.indexOf(Math.max(...counts));
  if (counts[axis]! < 2) return null;
  const middle = (firsts[axis]! + Math.floor(counts[axis]! / 2)) * side[axis]!;
  const hi = box.hi.map((end, a) => (a === axis ? middle : end)) as unknown as Vector3;
  const lo = box.lo.map((start, a) => (a === axis ? middle : start)) as unknown as Vector3;
  return [{ lo: box.lo, hi }, { lo, hi: box.hi }];
}

const arrays = {
  int8: Int8Array, uint8: Uint8Array, int16: Int16Array, uint16: Uint16Array,
  int32: Int32Array, uint32: Uint32Array, float32: Float32Array,
} as const;

export function arrayOf(type: VoxelTypeName, buffer: ArrayBuffer): VoxelArray {
  return new arrays[type](buffer) as VoxelArrays[VoxelTypeName];
}

export function newArray(type: VoxelTypeName, count: number, name: string): VoxelArray {
  try {
    return new arrays[type](count) as VoxelArrays[VoxelTypeName];
  } catch (cause) {
    throw new OctavoError("out_of_memory",
      `${name}: no room for ${count} voxels; read a smaller box or a coarser level`, { cause });
  }
}

/** Copies the voxels of a part into the array of the box around it. */
export function copyPart(part: VoxelArray, own: Box, all: VoxelArray, box: Box): void {
  const [width, height, depth] = sizeOf(own);
  const [rowLength, rows] = sizeOf(box);
  for (let z = 0; z < depth; ++z) {
    for (let y = 0; y < height; ++y) {
      const from = (z * height + y) * width;
      const to = ((z + own.lo[2] - box.lo[2]) * rows + y + own.lo[1] - box.lo[1]) * rowLength +
        own.lo[0] - box.lo[0];
      all.set(part.subarray(from, from + width), to);
    }
  }
}
