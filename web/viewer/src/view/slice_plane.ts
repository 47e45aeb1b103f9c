// One slice of a level as a rectangle of numbers, put together from the cells that are here.
import {
  type Axis,
  type Box, type Level,
  type Vec3,
  type VolumeFacts,
  type Voxels,
} from "../reader/volume.js";
import { CELL_SIDE, type Cell, boxSize, cellBox, cellsOf } from "../decode/cells.js";
import { type Orientation, sampleAt } from "./geometry.js";
import { powerOfTwo } from "./window.js";

/** Stands for a sample that is not here; no voxel is as large. */
export const MISSING = Math.fround(3.0e38);
/** Stands for what is not a number. */
export const NOT_A_NUMBER = Math.fround(-3.0e38);
const LARGEST = 2.9e38;

export interface PlaneRect {
  readonly level: number;
  /** The sample along the axis that the slice lies across. */
  readonly slice: number;
  /** First sample along the axes across and down, and how many. */
  readonly from: readonly [number, number];
  readonly size: readonly [number, number];
}

export type PlaneValues = Float32Array | Float64Array;

export interface Plane extends PlaneRect {
  /** Rows along `down`, samples along `across`: stored values. */
  readonly values: PlaneValues;
  readonly isComplete: boolean;
}

/** The part of a level's slice that covers a rectangle of voxels of level 0, in whole cells. */
export function planeRect(
  levels: readonly Level[],
  number: number,
  o: Orientation,
  voxel: number,
  shown: { lo: readonly [number, number]; hi: readonly [number, number] },
): PlaneRect {
  const level = levels[number]!;
  const ends = ([o.across, o.down] as const).map((axis, i) => {
    const f = level.factor[axis] * CELL_SIDE;
    const lo = Math.max(0, Math.floor(shown.lo[i]! / f)) * CELL_SIDE;
    const hi = Math.min(level.size[axis], Math.ceil((shown.hi[i]! + 1) / f) * CELL_SIDE);
    return [Math.min(lo, level.size[axis] - 1), Math.max(hi, lo + 1)] as const;
  });
  return {
    level: number,
    slice: sampleAt(level, o.axis, voxel),
    from: [ends[0]![0], ends[1]![0]],
    size: [ends[0]![1] - ends[0]![0], ends[1]![1] - ends[1]![0]],
  };
}

export function planeCells(o: Orientation, rect: PlaneRect): Cell[] {
  return cellsOf(rect.level, planeBox(o, rect));
}

function storable(value: number): number {
  if (Number.isNaN(value)) return NOT_A_NUMBER;
  return Math.max(-LARGEST, Math.min(LARGEST, value));
}

/** Grey values go to a texture of 32-bit floats, which could not tell large labels apart. */
function newValues(facts: VolumeFacts, rect: PlaneRect): PlaneValues {
  const count = rect.size[0] * rect.size[1];
  const isLarge = facts.kind === "labels" && facts.type.endsWith("32");
  return isLarge ? new Float64Array(count) : new Float32Array(count);
}

/** Stored values stand in textures in this unit: graphics cards may take floats below 1.2e-38 for
 *  0. A power of two, so that nothing is rounded; 1 where values are not as small. */
export function textureUnit(facts: Pick<VolumeFacts, "range">): number {
  const most = Math.max(...facts.range.map(Math.abs));
  return most < 1e-30 ? powerOfTwo(most) : 1;
}

/** The values of a plane for a texture. */
export function textureValues(plane: Plane, unit: number): Float32Array {
  const { values } = plane;
  if (unit === 1) return values instanceof Float32Array ? values : new Float32Array(values);
  return Float32Array.from(values, (v) =>
    v === MISSING || v === NOT_A_NUMBER ? v : storable(v / unit),
  );
}

function strides(size: Vec3): Vec3 {
  return [1, size[0], size[0] * size[1]];
}

/** Fills a plane from cells; what `peek` does not give stays MISSING. */
export function composePlane(
  facts: VolumeFacts,
  o: Orientation,
  rect: PlaneRect,
  peek: (cell: Cell) => Voxels | undefined,
): Plane {
  const values = newValues(facts, rect).fill(MISSING);
  const level = facts.levels[rect.level]!;
  let isComplete = true;
  for (const cell of planeCells(o, rect)) {
    const voxels = peek(cell);
    if (!voxels) {
      isComplete = false;
      continue;
    }
    const box = cellBox(level, cell.at);
    const size = boxSize(box);
    const step = strides(size);
    const start = (axis: Axis, i: 0 | 1): [number, number] => [
      Math.max(box.lo[axis], rect.from[i]),
      Math.min(box.hi[axis], rect.from[i] + rect.size[i]),
    ];
    const [x0, x1] = start(o.across, 0);
    const [y0, y1] = start(o.down, 1);
    const base = (rect.slice - box.lo[o.axis]) * step[o.axis];
    const isFloat = voxels instanceof Float32Array;
    for (let y = y0; y < y1; ++y) {
      let from =
        base + (y - box.lo[o.down]) * step[o.down] + (x0 - box.lo[o.across]) * step[o.across];
      let to = (y - rect.from[1]) * rect.size[0] + x0 - rect.from[0];
      for (let x = x0; x < x1; ++x) {
        const value = voxels[from]!;
        values[to++] = isFloat ? storable(value) : value;
        from += step[o.across];
      }
    }
  }
  return { ...rect, values, isComplete };
}

/** The samples that a plane shows. */
export function planeBox(o: Orientation, rect: PlaneRect): Box {
  const lo: [number, number, number] = [0, 0, 0];
  const hi: [number, number, number] = [0, 0, 0];
  lo[o.axis] = rect.slice;
  hi[o.axis] = rect.slice + 1;
  ([o.across, o.down] as const).forEach((axis, i) => {
    lo[axis] = rect.from[i as 0 | 1];
    hi[axis] = lo[axis] + rect.size[i as 0 | 1];
  });
  return { lo, hi };
}

/** The plane of a box that holds it and nothing else. */
export function planeOfBox(
  facts: VolumeFacts,
  o: Orientation,
  rect: PlaneRect,
  voxels: Voxels,
): Plane {
  const step = strides(boxSize(planeBox(o, rect)));
  const values = newValues(facts, rect);
  for (let y = 0; y < rect.size[1]; ++y) {
    for (let x = 0; x < rect.size[0]; ++x) {
      values[y * rect.size[0] + x] = storable(voxels[y * step[o.down] + x * step[o.across]]!);
    }
  }
  return { ...rect, values, isComplete: true };
}

/** The colors of a plane of labels, four bytes each; what is missing or hidden is clear. */
export function labelPixels(
  plane: Plane,
  rgbaOf: (label: number) => readonly [number, number, number, number],
): Uint8Array {
  const pixels = new Uint8Array(plane.values.length * 4);
  let last = NaN;
  let rgba: readonly [number, number, number, number] = [0, 0, 0, 0];
  plane.values.forEach((label, i) => {
    if (label === MISSING) return;
    if (label !== last) {
      rgba = rgbaOf(label);
      last = label;
    }
    pixels.set(rgba, 4 * i);
  });
  return pixels;
}
