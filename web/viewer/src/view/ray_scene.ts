// Which pages the 3-D view wants, which of them stand in the atlas, and the table that says so.
//
// What can be seen is known from the index alone: the smallest and largest voxel of every block;
// where voxels are NaN or infinite, from coarse samples besides.
// Pages that cannot be seen are neither read nor kept, and rays step over them.
import {
  AXES,
  type BlockRanges,
  type Box,
  type Vec3,
  type VolumeFacts,
  type Voxels,
} from "../reader/volume.js";
import { CELL_SIDE, type Cell, cellBox, cellKey, cellsOf, wholeBox } from "../decode/cells.js";
import { type Step } from "../decode/cell_store.js";
import {
  PAGE_SIDE,
  type Page,
  type PageVoxels,
  SlotTable,
  cellOfPage,
  pageGrid,
  pageKey,
  pageVoxels,
} from "./atlas.js";

/** What a range of real values looks like: whether any of it is seen. */
export type Visible = (low: number, high: number) => boolean;

/** Where cells are: those of a CellStore. */
export interface Cells {
  peek(cell: Cell): Voxels | undefined;
  has(cell: Cell): boolean;
}

interface Resident {
  readonly neighbors: number;
  readonly min: number;
  readonly max: number;
}

export interface Uploads {
  /** Puts a page into its slot. */
  upload(slot: Vec3, page: PageVoxels): void;
}

/** Blocks of the index beyond which it is not read: some 40 bytes each. */
export const MOST_BLOCKS = 200_000;

/** Every graphics card takes tables of so many pages along a side. */
const MOST_PAGES_ALONG = 256;

type Three = [number, number, number];

/** The places of a box, x fastest. */
function* places(lo: Vec3, hi: Vec3): Generator<Vec3> {
  for (let z = lo[2]; z < hi[2]; ++z) {
    for (let y = lo[1]; y < hi[1]; ++y) {
      for (let x = lo[0]; x < hi[0]; ++x) yield [x, y, z];
    }
  }
}

/**
 * The ranges of blocks with what is not finite in them, as far as coarse samples tell: the index
 * holds finite values alone, and a sample is not finite only where all its voxels are so.
 * Infinities count as the ends of all values, NaN as the lowest, as pages have them.
 * level  one whose cells are here
 */
export function withoutGaps(
  ranges: BlockRanges,
  facts: VolumeFacts,
  level: number,
  peek: (cell: Cell) => Voxels | undefined,
): BlockRanges {
  if (facts.type !== "float32") return ranges;
  const { grid, side } = ranges;
  const [min, max] = [ranges.min.slice(), ranges.max.slice()];
  const of = facts.levels[level]!;
  const widen = (sample: Vec3, value: number): void => {
    const first = AXES.map((a) => Math.floor((sample[a] * of.factor[a]) / side[a])) as Three;
    const end = AXES.map((a) =>
      Math.min(grid[a], Math.ceil(((sample[a] + 1) * of.factor[a]) / side[a]))) as Three;
    for (const [x, y, z] of places(first, end)) {
      const block = (z * grid[1] + y) * grid[0] + x;
      if (value > 0) max[block] = facts.range[1];
      else min[block] = facts.range[0];
    }
  };
  for (const cell of cellsOf(level, wholeBox(of))) {
    const voxels = peek(cell);
    if (!voxels || voxels.every((v: number) => Number.isFinite(v))) continue;
    const { lo, hi } = cellBox(of, cell.at);
    let i = 0;
    for (const sample of places(lo, hi)) {
      const value = voxels[i++]!;
      if (!Number.isFinite(value)) widen(sample, value);
    }
  }
  return { ...ranges, min, max };
}

export class RayScene {
  private readonly residents = new Map<string, Resident>();
  private readonly rangeCache = new Map<string, readonly [number, number]>();
  /** The finest level that is wanted; pages of the table are pages of it. */
  level: number;
  grid: Vec3;
  private wanted: Page[] = [];
  private wantedKeys = new Set<string>();

  constructor(
    private readonly facts: VolumeFacts,
    private readonly cells: Cells,
    readonly slots: SlotTable,
    private readonly coarsest: number,
    private ranges: BlockRanges | undefined,
  ) {
    this.level = coarsest;
    this.grid = pageGrid(facts.levels[coarsest]!);
  }

  /** They came after the pages that were chosen without them. */
  setRanges(ranges: BlockRanges): void {
    this.ranges = ranges;
    this.rangeCache.clear();
  }

  /** Bounds of the stored values of a page. */
  rangeOf(page: Page): readonly [number, number] {
    const key = pageKey(page);
    const resident = this.residents.get(key);
    if (resident && this.slots.find(page)) return [resident.min, resident.max];
    if (!this.ranges) return this.facts.range;
    const known = this.rangeCache.get(key);
    if (known) return known;
    const { grid, side, min, max } = this.ranges;
    const f = this.facts.levels[page.level]!.factor;
    const lo = AXES.map((a) => Math.floor((page.at[a] * PAGE_SIDE * f[a]) / side[a]));
    const hi = AXES.map((a) =>
      Math.min(grid[a], Math.ceil(((page.at[a] + 1) * PAGE_SIDE * f[a]) / side[a])),
    );
    let low = Infinity;
    let high = -Infinity;
    for (let z = lo[2]!; z < hi[2]!; ++z) {
      for (let y = lo[1]!; y < hi[1]!; ++y) {
        for (let x = lo[0]!; x < hi[0]!; ++x) {
          const i = (z * grid[1] + y) * grid[0] + x;
          low = Math.min(low, min[i]!);
          high = Math.max(high, max[i]!);
        }
      }
    }
    const range = [low, high] as const;
    this.rangeCache.set(key, range);
    return range;
  }

  private isVisible(page: Page, visible: Visible, clip: Box): boolean {
    const f = this.facts.levels[page.level]!.factor;
    for (const a of AXES) {
      const lo = page.at[a] * PAGE_SIDE * f[a];
      if (lo >= clip.hi[a] || lo + PAGE_SIDE * f[a] <= clip.lo[a]) return false;
    }
    const [low, high] = this.rangeOf(page).map(
      (v) => v * this.facts.slope + this.facts.intercept,
    );
    return visible(Math.min(low!, high!), Math.max(low!, high!));
  }

  private visiblePages(level: number, visible: Visible, clip: Box): Page[] {
    const grid = pageGrid(this.facts.levels[level]!);
    const pages: Page[] = [];
    for (let z = 0; z < grid[2]; ++z) {
      for (let y = 0; y < grid[1]; ++y) {
        for (let x = 0; x < grid[0]; ++x) {
          const page: Page = { level, at: [x, y, z] };
          if (this.isVisible(page, visible, clip)) pages.push(page);
        }
      }
    }
    return pages;
  }

  /**
   * Chooses pages: those seen of all levels from the coarsest to the asked one, or to the finest
   * that the atlas has room for. Gives the cells that are still to be read, coarse first.
   */
  plan(asked: number, visible: Visible, clip: Box): Step[] {
    let pages = this.visiblePages(this.coarsest, visible, clip);
    let level = this.coarsest;
    for (let k = this.coarsest - 1; k >= Math.min(asked, this.coarsest); --k) {
      const grid = pageGrid(this.facts.levels[k]!);
      if (grid[0] * grid[1] * grid[2] > 1 << 20) break;
      if (Math.max(...grid) > MOST_PAGES_ALONG) break;
      const more = this.visiblePages(k, visible, clip);
      if (pages.length + more.length > this.slots.capacity) break;
      pages = [...pages, ...more];
      level = k;
    }
    this.level = level;
    this.grid = pageGrid(this.facts.levels[level]!);
    this.wanted = pages;
    this.wantedKeys = new Set(pages.map(pageKey));
    return this.missing();
  }

  private missing(): Step[] {
    const steps = new Map<number, Map<string, Cell>>();
    for (const page of this.wanted) {
      if (this.residents.has(pageKey(page)) && this.slots.find(page)) continue;
      const cell = cellOfPage(page);
      const step = steps.get(page.level) ?? new Map<string, Cell>();
      step.set(cellKey(cell), cell);
      steps.set(page.level, step);
    }
    return [...steps]
      .sort(([a], [b]) => b - a)
      .map(([level, cells]) => ({ level, cells: [...cells.values()] }));
  }

  private neighborsHere(page: Page): number {
    const own = cellOfPage(page);
    const level = this.facts.levels[page.level]!;
    let here = 0;
    for (let n = 0; n < 27; ++n) {
      const at: Vec3 = [
        own.at[0] + (n % 3) - 1,
        own.at[1] + (Math.floor(n / 3) % 3) - 1,
        own.at[2] + Math.floor(n / 9) - 1,
      ];
      if (AXES.some((a) => at[a] < 0 || at[a] * CELL_SIDE >= level.size[a])) continue;
      if (this.cells.has({ level: page.level, at })) here += 1;
    }
    return here;
  }

  /** Uploads at most so many pages whose cells are here; whether anything changed. */
  load(uploads: Uploads, most: number): boolean {
    let count = 0;
    for (const page of this.wanted) {
      if (count >= most) break;
      const key = pageKey(page);
      const resident = this.slots.find(page) ? this.residents.get(key) : undefined;
      if (!this.cells.has(cellOfPage(page))) continue;
      const neighbors = this.neighborsHere(page);
      if (resident && resident.neighbors >= neighbors) continue;
      const { levels, range } = this.facts;
      const voxels = pageVoxels(levels[page.level]!, page, range, (c) => this.cells.peek(c));
      const slot = voxels && this.slots.take(page, this.wantedKeys);
      if (!slot) continue;
      uploads.upload(slot.at, voxels);
      this.residents.set(key, { neighbors, min: voxels.min, max: voxels.max });
      count += 1;
    }
    return count > 0;
  }

  private isResident(page: Page): boolean {
    return this.residents.has(pageKey(page)) && this.slots.find(page) !== undefined;
  }

  /** The finest level of which every wanted page is here. */
  shownLevel(): number {
    for (let k = this.level; k < this.coarsest; ++k) {
      const pages = this.wanted.filter((page) => page.level === k);
      if (pages.every((page) => this.isResident(page))) return k;
    }
    return this.coarsest;
  }

  /** Four bytes per page of the grid, and two floats: smallest and largest value. */
  table(): { entries: Uint8Array; reach: Float32Array } {
    const [gx, gy, gz] = this.grid;
    const entries = new Uint8Array(4 * gx * gy * gz);
    const reach = new Float32Array(2 * gx * gy * gz);
    const finest = this.facts.levels[this.level]!.factor;
    let i = 0;
    for (let z = 0; z < gz; ++z) {
      for (let y = 0; y < gy; ++y) {
        for (let x = 0; x < gx; ++x, ++i) {
          for (let level = this.level; level <= this.coarsest; ++level) {
            const f = this.facts.levels[level]!.factor;
            const at = [x, y, z].map((p, a) =>
              Math.floor((p * finest[a as 0]!) / f[a as 0]!),
            ) as unknown as Vec3;
            const page = { level, at };
            const key = pageKey(page);
            if (!this.wantedKeys.has(key)) break;
            const slot = this.isResident(page) ? this.slots.find(page) : undefined;
            if (!slot) continue;
            entries.set([...slot.at, 1 + level - this.level], 4 * i);
            const resident = this.residents.get(key)!;
            reach.set([resident.min, resident.max], 2 * i);
            break;
          }
        }
      }
    }
    return { entries, reach };
  }
}
