// Measurements on slices, in millimeters where the spacing is known.
import {
  AXES,
  type Box,
  type Geometry,
  type Level,
  type Vec3,
  type Voxels,
} from "../reader/volume.js";
import { boxSize } from "../decode/cells.js";
import { dot, plus } from "./camera.js";
import { type Orientation, toWorld } from "./geometry.js";

export type MeasureKind = "distance" | "angle" | "roi";

/** Points are fractional voxels of level 0. */
export interface Measurement {
  readonly kind: MeasureKind;
  /** The axis of the slice that it was drawn on. */
  readonly axis: 0 | 1 | 2;
  readonly slice: number;
  readonly points: readonly Vec3[];
}

export const POINTS_NEEDED: Readonly<Record<MeasureKind, number>> = {
  distance: 2,
  angle: 3,
  roi: 2,
};

export function distanceMm(g: Geometry, a: Vec3, b: Vec3): number {
  const between = plus(toWorld(g, b), toWorld(g, a), -1);
  return Math.sqrt(dot(between, between));
}

/** The angle at the second of three points, degrees. */
export function angleDegrees(g: Geometry, points: readonly Vec3[]): number {
  const [a, b, c] = points.map((p) => toWorld(g, p)) as [Vec3, Vec3, Vec3];
  const u = plus(a, b, -1);
  const v = plus(c, b, -1);
  const lengths = Math.sqrt(dot(u, u) * dot(v, v));
  if (lengths === 0) return NaN;
  return (Math.acos(Math.max(-1, Math.min(1, dot(u, v) / lengths))) * 180) / Math.PI;
}

/** The samples of a level whose centers lie between two corners on a slice; one or more. */
export function roiBox(
  level: Level,
  o: Orientation,
  slice: number,
  points: readonly Vec3[],
): Box {
  const lo: [number, number, number] = [0, 0, 0];
  const hi: [number, number, number] = [0, 0, 0];
  for (const a of AXES) {
    const f = level.factor[a];
    const center = (voxel: number): number => (voxel + 0.5) / f - 0.5;
    const ends = a === o.axis ? [slice, slice] : points.map((p) => p[a]);
    const first = Math.min(...ends);
    const last = Math.max(...ends);
    const from = a === o.axis ? Math.floor(slice / f) : Math.ceil(center(first));
    const to = a === o.axis ? from : Math.floor(center(last));
    lo[a] = Math.min(level.size[a] - 1, Math.max(0, from));
    hi[a] = Math.min(level.size[a], Math.max(lo[a] + 1, to + 1));
  }
  return { lo, hi };
}

export interface RoiStatistics {
  readonly count: number;
  readonly mean: number;
  readonly deviation: number;
  readonly min: number;
  readonly max: number;
}

/** Statistics of real values that come part by part, those of `octavo measure`: the deviation is
 *  that of all samples, over their count. What is not a number does not count. */
export class RegionSums {
  private count = 0;
  private mean = 0;
  private squares = 0;
  private min = Infinity;
  private max = -Infinity;

  constructor(
    private readonly slope: number,
    private readonly intercept: number,
  ) {}

  /** The samples of a box out of those of a larger one. */
  add(voxels: Voxels, from: Box, part: Box): void {
    const size = boxSize(from);
    for (let z = part.lo[2]; z < part.hi[2]; ++z) {
      for (let y = part.lo[1]; y < part.hi[1]; ++y) {
        const row = ((z - from.lo[2]) * size[1] + y - from.lo[1]) * size[0] - from.lo[0];
        for (let x = part.lo[0]; x < part.hi[0]; ++x) this.addStored(voxels[row + x]!);
      }
    }
  }

  private addStored(stored: number): void {
    const value = this.slope * stored + this.intercept;
    if (!Number.isFinite(value)) return;
    this.count += 1;
    const step = value - this.mean;
    this.mean += step / this.count;
    this.squares += step * (value - this.mean);
    if (value < this.min) this.min = value;
    if (value > this.max) this.max = value;
  }

  get statistics(): RoiStatistics {
    const { count, mean, squares, min, max } = this;
    return { count, mean, deviation: count > 0 ? Math.sqrt(squares / count) : 0, min, max };
  }
}

/** A round length of at most `most` mm: 1, 2 or 5 times a power of ten; and its text. */
export function roundLength(most: number): { mm: number; text: string } {
  const power = 10 ** Math.floor(Math.log10(most));
  const mm = power * (most >= 5 * power ? 5 : most >= 2 * power ? 2 : 1);
  if (mm >= 1e6) return { mm, text: `${Math.round(mm / 1e6)} km` };
  if (mm >= 1000) return { mm, text: `${Math.round(mm / 1000)} m` };
  if (mm >= 10) return { mm, text: `${Math.round(mm) / 10} cm` };
  if (mm >= 1) return { mm, text: `${Math.round(mm)} mm` };
  return { mm, text: `${Number((mm * 1000).toPrecision(1))} µm` };
}
