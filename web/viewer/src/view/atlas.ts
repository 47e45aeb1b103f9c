// A 3-D texture of pages: where each page of each level stands in it, and which is thrown away.
//
// A page is 32 x 32 x 32 samples of a level with a border of one sample all around, so that values
// between samples, and across the faces of pages, are interpolated within one page.
//
//     page   32 samples          slot   34 samples: one more at each end
//     slots  side x side x side, at most 255 along an axis (8 bits of the page table)
import { AXES, type Level, type Vec3, type Voxels } from "../reader/volume.js";
import { CELL_SIDE, type Cell, boxSize, cellBox } from "../decode/cells.js";

export const PAGE_SIDE = 32;
export const SLOT_SIDE = PAGE_SIDE + 2;
const MOST_SLOTS = 255;

export function pageGrid(level: Level): Vec3 {
  return AXES.map((a) => Math.ceil(level.size[a] / PAGE_SIDE)) as unknown as Vec3;
}

/** Slots along each axis of a texture for so many pages, within limits of memory and of sides. */
export function atlasShape(
  pages: number,
  bytesPerVoxel: number,
  mostBytes: number,
  longestSide: number,
): Vec3 {
  const longest = Math.min(MOST_SLOTS, Math.floor(longestSide / SLOT_SIDE));
  const affordable = Math.max(1, Math.floor(mostBytes / (SLOT_SIDE ** 3 * bytesPerVoxel)));
  const count = Math.min(pages, affordable);
  const x = Math.min(longest, Math.ceil(Math.cbrt(count)));
  const y = Math.min(longest, Math.ceil(Math.sqrt(count / x)));
  return [
    x,
    y,
    Math.max(1, Math.min(longest, Math.floor(affordable / (x * y)), Math.ceil(count / (x * y)))),
  ];
}

export interface Page {
  readonly level: number;
  readonly at: Vec3;
}

export function pageKey(page: Page): string {
  return `${page.level}:${page.at[0]}:${page.at[1]}:${page.at[2]}`;
}

/** The cell whose samples a page takes. */
export function cellOfPage(page: Page): Cell {
  const at = page.at.map((p) => Math.floor((p * PAGE_SIDE) / CELL_SIDE)) as unknown as Vec3;
  return { level: page.level, at };
}

export interface Slot {
  readonly number: number;
  readonly at: Vec3;
}

/** Who stands where. A slot is given to a page until the page is released or pushed out. */
export class SlotTable {
  private readonly slots = new Map<string, Slot>();
  private readonly free: number[] = [];

  constructor(readonly shape: Vec3) {
    for (let n = shape[0] * shape[1] * shape[2] - 1; n >= 0; --n) this.free.push(n);
  }

  get capacity(): number {
    return this.shape[0] * this.shape[1] * this.shape[2];
  }

  get used(): number {
    return this.slots.size;
  }

  find(page: Page): Slot | undefined {
    return this.slots.get(pageKey(page));
  }

  /** A slot for a page; undefined where all are taken by pages in `kept`. */
  take(page: Page, kept: ReadonlySet<string>): Slot | undefined {
    const key = pageKey(page);
    const found = this.slots.get(key);
    if (found) return found;
    if (this.free.length === 0) {
      for (const [other, slot] of this.slots) {
        if (kept.has(other)) continue;
        this.slots.delete(other);
        this.free.push(slot.number);
        break;
      }
    }
    const number = this.free.pop();
    if (number === undefined) return undefined;
    const [x, y] = this.shape;
    const at: Vec3 = [number % x, Math.floor(number / x) % y, Math.floor(number / (x * y))];
    const slot = { number, at };
    this.slots.set(key, slot);
    return slot;
  }
}

export interface PageVoxels {
  /** SLOT_SIDE ** 3 samples, x fastest. */
  readonly voxels: Voxels;
  readonly min: number;
  readonly max: number;
}

/** Below all values that are drawn. */
export const LOWEST_FLOAT = -3.4e38;

/** What NaN is in pages: as far below all values as these are apart. */
export function nanWithin([lowest, highest]: readonly [number, number]): number {
  const width = highest - lowest || Math.abs(lowest) || 1;
  return Math.max(LOWEST_FLOAT, lowest - width);
}

/** Fills the slot of a page from cells; undefined without the page's own cell. Beyond the level,
 *  and where a cell beside it is not here, the outermost samples go on. Infinities count as the
 *  lowest or highest of `range`, NaN as nanWithin() has it, and to min and max as the lowest. */
export function pageVoxels(
  level: Level,
  page: Page,
  range: readonly [number, number],
  peek: (cell: Cell) => Voxels | undefined,
): PageVoxels | undefined {
  const [lowest, highest] = range;
  const nan = nanWithin(range);
  const own = cellOfPage(page);
  const ownVoxels = peek(own);
  if (!ownVoxels) return undefined;
  const out = new (ownVoxels.constructor as new (n: number) => Voxels)(SLOT_SIDE ** 3);
  const near = new Map<number, { voxels: Voxels; size: Vec3 }>();
  for (let n = 0; n < 27; ++n) {
    const at: Vec3 = [
      own.at[0] + (n % 3) - 1,
      own.at[1] + (Math.floor(n / 3) % 3) - 1,
      own.at[2] + Math.floor(n / 9) - 1,
    ];
    if (AXES.some((a) => at[a] < 0 || at[a] * CELL_SIDE >= level.size[a])) continue;
    const voxels = n === 13 ? ownVoxels : peek({ level: page.level, at });
    if (voxels) near.set(n, { voxels, size: boxSize(cellBox(level, at)) });
  }
  const ownBox = cellBox(level, own.at);
  let min = Infinity;
  let max = -Infinity;
  let to = 0;
  for (let z = -1; z <= PAGE_SIDE; ++z) {
    for (let y = -1; y <= PAGE_SIDE; ++y) {
      for (let x = -1; x <= PAGE_SIDE; ++x) {
        const at = [x, y, z].map((v, a) =>
          Math.min(level.size[a as 0]! - 1, Math.max(0, page.at[a as 0]! * PAGE_SIDE + v)),
        );
        const sample = sampleNear(near, own.at, ownBox.lo, ownBox.hi, at as unknown as Vec3);
        let value = sample;
        if (!Number.isFinite(value)) value = value > 0 ? highest : lowest;
        out[to++] = Number.isNaN(sample) ? nan : value;
        if (value < min) min = value;
        if (value > max) max = value;
      }
    }
  }
  return { voxels: out, min, max };
}

function sampleNear(
  near: ReadonlyMap<number, { voxels: Voxels; size: Vec3 }>,
  own: Vec3,
  lo: Vec3,
  hi: Vec3,
  sample: Vec3,
): number {
  const [x, y, z] = sample;
  const dx = x < lo[0] ? 0 : x >= hi[0] ? 2 : 1;
  const dy = y < lo[1] ? 0 : y >= hi[1] ? 2 : 1;
  const dz = z < lo[2] ? 0 : z >= hi[2] ? 2 : 1;
  const there = near.get(dx + 3 * dy + 9 * dz);
  if (there) {
    const cx = x - (own[0] + dx - 1) * CELL_SIDE;
    const cy = y - (own[1] + dy - 1) * CELL_SIDE;
    const cz = z - (own[2] + dz - 1) * CELL_SIDE;
    return there.voxels[(cz * there.size[1] + cy) * there.size[0] + cx]!;
  }
  const inside: Vec3 = [
    Math.min(hi[0] - 1, Math.max(lo[0], x)) - lo[0],
    Math.min(hi[1] - 1, Math.max(lo[1], y)) - lo[1],
    Math.min(hi[2] - 1, Math.max(lo[2], z)) - lo[2],
  ];
  const cell = near.get(13)!;
  return cell.voxels[(inside[2] * cell.size[1] + inside[1]) * cell.size[0] + inside[0]]!;
}
