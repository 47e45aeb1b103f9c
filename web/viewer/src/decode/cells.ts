// Levels cut into cells of 64 x 64 x 64 samples: what is read, kept and thrown away as one.
import { AXES, type Axis, type Box, type Level, type Vec3 } from "../reader/volume.js";

export const CELL_SIDE = 64;

export interface Cell {
  readonly level: number;
  readonly at: Vec3;
}

export function cellKey(cell: Cell): string {
  return `${cell.level}:${cell.at[0]}:${cell.at[1]}:${cell.at[2]}`;
}

/** The samples of a cell; fewer than its sides at the end of the level. */
export function cellBox(level: Level, at: Vec3): Box {
  const lo = AXES.map((a) => at[a] * CELL_SIDE) as unknown as Vec3;
  const hi = AXES.map((a) => Math.min(level.size[a], lo[a] + CELL_SIDE)) as unknown as Vec3;
  return { lo, hi };
}

export function boxSize(box: Box): Vec3 {
  return AXES.map((a) => box.hi[a] - box.lo[a]) as unknown as Vec3;
}

export function boxVoxels(box: Box): number {
  const size = boxSize(box);
  return size[0] * size[1] * size[2];
}

/** The cells that a box of samples meets; z slowest. */
export function cellsOf(number: number, box: Box): Cell[] {
  const cells: Cell[] = [];
  const from = (a: Axis): number => Math.floor(box.lo[a] / CELL_SIDE);
  const to = (a: Axis): number => Math.ceil(box.hi[a] / CELL_SIDE);
  for (let z = from(2); z < to(2); ++z) {
    for (let y = from(1); y < to(1); ++y) {
      for (let x = from(0); x < to(0); ++x) cells.push({ level: number, at: [x, y, z] });
    }
  }
  return cells;
}

export function wholeBox(level: Level): Box {
  return { lo: [0, 0, 0], hi: level.size };
}

/** Every graphics card takes textures of so many samples along a side. */
const PREVIEW_SIDE = 4096;

/** The level shown first: the finest of at most so many samples, of which one request is enough. */
export function previewLevel(levels: readonly Level[], maximum = 1 << 18): number {
  const found = levels.findIndex(
    ({ size }) =>
      size[0] * size[1] * size[2] <= maximum && Math.max(...size) <= PREVIEW_SIDE,
  );
  return found < 0 ? levels.length - 1 : found;
}
