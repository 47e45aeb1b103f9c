// Names of the cubes of an octree, as `octavo probe` prints them. One digit per bit of the
// coordinates, the highest first: 4 z + 2 x + y.
import { type Vec3 } from "../reader/volume.js";

/** The smallest n with every side at most 2^n. */
export function rootLevel(size: Vec3): number {
  let n = 0;
  while (2 ** n < Math.max(...size)) ++n;
  return n;
}

/** The voxel's code in mixed octal: n digits. */
export function oCode(voxel: Vec3, n: number): string {
  let text = "";
  for (let i = n - 1; i >= 0; --i) {
    const bit = (v: number): number => Math.floor(v / 2 ** i) % 2;
    text += String(4 * bit(voxel[2]) + 2 * bit(voxel[0]) + bit(voxel[1]));
  }
  return text;
}
