// From indices to the world and back. LPS, mm; 3x3 matrices are row-major.
import type { Level, Vector3 } from "../api.js";

type Matrix3 = readonly number[];

const times = (m: Matrix3, v: Vector3): Vector3 => [
  m[0]! * v[0] + m[1]! * v[1] + m[2]! * v[2],
  m[3]! * v[0] + m[4]! * v[1] + m[5]! * v[2],
  m[6]! * v[0] + m[7]! * v[1] + m[8]! * v[2]];

/** Requires a determinant other than 0, which every file has. */
function inverse(m: Matrix3): Matrix3 {
  const minor = (a: number, b: number, c: number, d: number) => m[a]! * m[d]! - m[b]! * m[c]!;
  const determinant =
    m[0]! * minor(4, 5, 7, 8) - m[1]! * minor(3, 5, 6, 8) + m[2]! * minor(3, 4, 6, 7);
  return [
    minor(4, 5, 7, 8), -minor(1, 2, 7, 8), minor(1, 2, 4, 5),
    -minor(3, 5, 6, 8), minor(0, 2, 6, 8), -minor(0, 2, 3, 5),
    minor(3, 4, 6, 7), -minor(0, 1, 6, 7), minor(0, 1, 3, 4),
  ].map((value) => value / determinant);
}

export function toWorld(index: Vector3, level: Level, direction: Matrix3): Vector3 {
  const scaled = index.map((value, axis) => value * level.spacingMm[axis]!);
  const turned = times(direction, scaled as unknown as Vector3);
  return turned.map((value, axis) => value + level.originMm[axis]!) as unknown as Vector3;
}

export function toIndex(world: Vector3, level: Level, direction: Matrix3): Vector3 {
  const moved = world.map((value, axis) => value - level.originMm[axis]!);
  const turned = times(inverse(direction), moved as unknown as Vector3);
  return turned.map((value, axis) => value / level.spacingMm[axis]!) as unknown as Vector3;
}

/** The coarsest level with samples at most so far apart, but for axes that are never that fine. */
export function levelFor(levels: readonly Level[], spacingMm: number): number {
  const isFine = (level: Level) => level.spacingMm.every(
    (spacing, axis) => spacing <= Math.max(spacingMm, levels[0]!.spacingMm[axis]!) * (1 + 1e-9));
  let coarsest = 0;
  for (const level of levels) {
    if (isFine(level)) coarsest = level.level;
  }
  return coarsest;
}
