// Places: voxels of levels, millimeters of the patient, sides of a picture.
import {
  AXES,
  type Axis,
  type Box,
  type Geometry,
  type Level,
  type Vec3,
  type VolumeFacts,
} from "../reader/volume.js";

export function toWorld(g: Geometry, index: Vec3): Vec3 {
  const row = (r: number): number => {
    let sum = g.origin[r as Axis];
    for (const a of AXES) sum += g.direction[3 * r + a]! * g.spacing[a] * index[a];
    return sum;
  };
  return [row(0), row(1), row(2)];
}

type Place = Pick<VolumeFacts, "geometry" | "isPlaceKnown" | "isSpacingKnown">;

/** The place of a voxel in mm, with the digits that tell it from the next voxel. */
export function placeText({ geometry, isPlaceKnown, isSpacingKnown }: Place, voxel: Vec3): string {
  if (!isSpacingKnown) return "";
  const digits = Math.max(1, Math.ceil(-Math.log10(Math.min(...geometry.spacing))));
  const text = toWorld(geometry, voxel).map((v, a) => {
    const side = isPlaceKnown ? `${(v < 0 ? "RAI" : "LPS")[a]} ` : "";
    return `${side}${(isPlaceKnown ? Math.abs(v) : v).toFixed(digits)}`;
  });
  return `${text.join(", ")} mm`;
}

/** The fractional index of a world position; the direction must be invertible. */
export function toIndex(g: Geometry, world: Vec3): Vec3 {
  const d = g.direction as number[];
  const [a, b, c, e, f, h, i, j, k] = d as [
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
    number,
  ];
  const determinant = a * (f * k - h * j) - b * (e * k - h * i) + c * (e * j - f * i);
  const p = AXES.map((r) => world[r] - g.origin[r]) as [number, number, number];
  const x = p[0] * (f * k - h * j) + p[1] * (c * j - b * k) + p[2] * (b * h - c * f);
  const y = p[0] * (h * i - e * k) + p[1] * (a * k - c * i) + p[2] * (c * e - a * h);
  const z = p[0] * (e * j - f * i) + p[1] * (b * i - a * j) + p[2] * (a * f - b * e);
  return [
    x / determinant / g.spacing[0],
    y / determinant / g.spacing[1],
    z / determinant / g.spacing[2],
  ];
}

/** The sample of a level that covers a voxel of level 0 along an axis. */
export function sampleAt(level: Level, axis: Axis, voxel: number): number {
  return Math.min(level.size[axis] - 1, Math.max(0, Math.floor(voxel / level.factor[axis])));
}

export function clampVoxel(size: Vec3, at: Vec3): Vec3 {
  return AXES.map((a) =>
    Math.min(size[a] - 1, Math.max(0, Math.round(at[a]))),
  ) as unknown as Vec3;
}

/** The box of another volume's voxels that a box of one covers. */
export function boxIn(box: Box, to: (corner: Vec3) => Vec3, size: Vec3): Box {
  const lo: [number, number, number] = [...size];
  const hi: [number, number, number] = [0, 0, 0];
  for (let n = 0; n < 8; ++n) {
    const corner = AXES.map((a) => ((n >> a) & 1 ? box.hi[a] : box.lo[a]) - 0.5);
    const found = to(corner as unknown as Vec3);
    for (const a of AXES) {
      lo[a] = Math.min(lo[a], Math.max(0, Math.floor(found[a] + 0.5)));
      hi[a] = Math.max(hi[a], Math.min(size[a], Math.ceil(found[a] + 0.5)));
    }
  }
  return { lo, hi };
}

/** How the two index axes of a slice lie in its picture. */
export interface Orientation {
  readonly axis: Axis;
  readonly across: Axis;
  readonly down: Axis;
  /** The index falls to the right, or downwards. */
  readonly flipsAcross: boolean;
  readonly flipsDown: boolean;
  readonly left: string;
  readonly right: string;
  readonly top: string;
  readonly bottom: string;
  readonly name: "axial" | "coronal" | "sagittal";
}

/**
 * The sides of the body in a direction (LPS), a unit vector: one letter where the nearest is clear,
 * more where it is not, the nearest first.
 */
export function sideLetters(direction: Vec3): string {
  const clear = 0.38; // the sine of 22 degrees
  const length = (a: Axis): number => Math.abs(direction[a]);
  const order = [...AXES].sort((a, b) => length(b) - length(a) || a - b);
  return order
    .filter((a, i) => i === 0 || length(a) >= clear)
    .map((a) => (direction[a] < 0 ? "RAI" : "LPS")[a])
    .join("");
}

const ORDERS: readonly Vec3[] = [
  [0, 1, 2],
  [0, 2, 1],
  [1, 0, 2],
  [1, 2, 0],
  [2, 0, 1],
  [2, 1, 0],
];

interface WorldAxis {
  readonly axis: Axis;
  readonly isNegative: boolean;
}

/** For each index axis the world axis that it is nearest to; all three differ. */
export function nearestWorldAxes(g: Geometry): readonly WorldAxis[] {
  let best = ORDERS[0]!;
  let bestSum = -1;
  for (const order of ORDERS) {
    let sum = 0;
    for (const a of AXES) sum += Math.abs(g.direction[3 * order[a] + a]!);
    if (sum > bestSum) {
      bestSum = sum;
      best = order;
    }
  }
  return AXES.map((a) => ({
    axis: best[a] as Axis,
    isNegative: g.direction[3 * best[a] + a]! < 0,
  }));
}

/**
 * Slices across an index axis as `octavo slice` draws them: axial from the feet, coronal from the
 * front, sagittal from the left. Neurological: right and left of axial and coronal ones change
 * places.
 */
export function orientationOf(g: Geometry, axis: Axis, isRadiological = true): Orientation {
  const world = nearestWorldAxes(g);
  let across: Axis = axis === 0 ? 1 : 0;
  let down: Axis = axis === 2 ? 1 : 2;
  if (world[across]!.axis > world[down]!.axis) [across, down] = [down, across];
  const a = world[across]!;
  const d = world[down]!;
  const isUpright = d.axis === 2;
  const isMirrored = !isRadiological && a.axis === 0;
  const flipsAcross = a.isNegative !== isMirrored;
  const flipsDown = d.isNegative !== isUpright;
  const side = (index: Axis, isTurned: boolean): string => {
    const sign = isTurned ? -1 : 1;
    return sideLetters(AXES.map((r) => sign * g.direction[3 * r + index]!) as unknown as Vec3);
  };
  return {
    axis,
    across,
    down,
    flipsAcross,
    flipsDown,
    left: side(across, !flipsAcross),
    right: side(across, flipsAcross),
    top: side(down, !flipsDown),
    bottom: side(down, flipsDown),
    name: (["sagittal", "coronal", "axial"] as const)[world[axis]!.axis],
  };
}

/** The coarsest level whose samples are nowhere longer than `mm` along the two axes of a slice. */
export function levelForPixels(
  levels: readonly Level[],
  g: Geometry,
  o: Orientation,
  mm: number,
): number {
  let found = 0;
  for (let k = 0; k < levels.length; ++k) {
    const f = levels[k]!.factor;
    if (f[o.across] * g.spacing[o.across] > mm || f[o.down] * g.spacing[o.down] > mm) break;
    found = k;
  }
  return found;
}

/** "1/4" for a level whose finest axis was halved twice; "1/1" for the scan itself. */
export function levelText(level: Level): string {
  return "1/" + Math.max(...level.factor);
}
