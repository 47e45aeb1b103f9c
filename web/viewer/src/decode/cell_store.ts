// Decoded cells: kept up to a limit of memory, asked for step by step, coarse before fine.
//
// Each owner (a panel, the cursor, a measurement) says what it wants as steps. One step is one
// read: the smallest box around its cells that are not here. A step that is no longer wanted is
// aborted.
import {
  type Axis,
  type Box,
  AXES,
  type Vec3,
  type Volume,
  type Voxels,
} from "../reader/volume.js";
import { type Cell, boxSize, cellBox, cellKey, cellsOf } from "./cells.js";

export interface Step {
  readonly level: number;
  readonly cells: readonly Cell[];
}

interface Running {
  readonly keys: ReadonlySet<string>;
  readonly level: number;
  readonly box: Box;
  readonly abort: AbortController;
}

interface Owner {
  steps: readonly Step[];
  running: Running | undefined;
}

/** The smallest box of samples around cells of one level. */
export function boxAround(volume: Volume, step: Step): Box {
  const lo = [Infinity, Infinity, Infinity];
  const hi = [0, 0, 0];
  for (const cell of step.cells) {
    const box = cellBox(volume.facts.levels[step.level]!, cell.at);
    for (const a of AXES) {
      lo[a] = Math.min(lo[a]!, box.lo[a]);
      hi[a] = Math.max(hi[a]!, box.hi[a]);
    }
  }
  return { lo: lo as unknown as Vec3, hi: hi as unknown as Vec3 };
}

/** A part of a dense array of voxels. */
export function cutOut(voxels: Voxels, from: Box, part: Box): Voxels {
  const whole = boxSize(from);
  const size = boxSize(part);
  const out = new (voxels.constructor as new (n: number) => Voxels)(size[0] * size[1] * size[2]);
  const first = AXES.map((a) => part.lo[a] - from.lo[a]) as unknown as Vec3;
  let to = 0;
  for (let z = 0; z < size[2]; ++z) {
    for (let y = 0; y < size[1]; ++y) {
      const at = ((first[2] + z) * whole[1] + first[1] + y) * whole[0] + first[0];
      out.set(voxels.subarray(at, at + size[0]) as never, to);
      to += size[0];
    }
  }
  return out;
}

/** Halves of a box along its longest axis, at a face of cells. */
function halves(box: Box, side: number): [Box, Box] | undefined {
  const size = boxSize(box);
  const axis = size.indexOf(Math.max(...size)) as Axis;
  const middle = Math.round((box.lo[axis] + size[axis] / 2) / side) * side;
  if (middle <= box.lo[axis] || middle >= box.hi[axis]) return undefined;
  const hi = [...box.hi] as [number, number, number];
  const lo = [...box.lo] as [number, number, number];
  hi[axis] = middle;
  lo[axis] = middle;
  return [
    { lo: box.lo, hi },
    { lo, hi: box.hi },
  ];
}

/** Voxels that one read gives at most. */
const MOST_VOXELS = 1 << 25;

export class CellStore {
  private readonly cells = new Map<string, Voxels>();
  private readonly owners = new Map<string, Owner>();
  private readonly pinned = new Set<string>();
  private bytes = 0;
  private isClosed = false;
  /** What stopped reading; wanted steps wait until `retry`. */
  failure: Error | undefined;

  constructor(
    readonly volume: Volume,
    readonly budgetBytes: number,
    private readonly onChange: () => void,
    private readonly onFailure: (error: Error) => void,
  ) {}

  get heldBytes(): number {
    return this.bytes;
  }

  /** The voxels of a cell that is here. */
  peek(cell: Cell): Voxels | undefined {
    const key = cellKey(cell);
    const voxels = this.cells.get(key);
    if (voxels) {
      this.cells.delete(key);
      this.cells.set(key, voxels);
    }
    return voxels;
  }

  has(cell: Cell): boolean {
    return this.cells.has(cellKey(cell));
  }

  hasAll(step: Step): boolean {
    return step.cells.every((cell) => this.has(cell));
  }

  /** What an owner wants from now on, in this order; it forgets what the owner wanted before. */
  want(name: string, steps: readonly Step[]): void {
    const owner = this.owners.get(name) ?? { steps: [], running: undefined };
    owner.steps = steps;
    this.owners.set(name, owner);
    if (owner.running) {
      const wanted = new Set(steps.flatMap((step) => step.cells.map(cellKey)));
      const isWanted = [...owner.running.keys].some((key) => wanted.has(key));
      if (isWanted) return;
      owner.running.abort.abort();
      owner.running = undefined;
    }
    this.advance(name);
  }

  /** Cells that are never thrown away. */
  pin(cells: readonly Cell[]): void {
    for (const cell of cells) this.pinned.add(cellKey(cell));
  }

  get isBusy(): boolean {
    return [...this.owners.values()].some((owner) => owner.running !== undefined);
  }

  /** Boxes that are wanted and not here, for a count of their bytes. */
  missing(): { level: number; box: Box }[] {
    const found: { level: number; box: Box }[] = [];
    for (const owner of this.owners.values()) {
      for (const step of owner.steps) {
        const cells = step.cells.filter((cell) => !this.has(cell));
        if (cells.length === 0) continue;
        found.push({
          level: step.level,
          box: boxAround(this.volume, { level: step.level, cells }),
        });
      }
    }
    return found;
  }

  retry(): void {
    this.failure = undefined;
    for (const name of this.owners.keys()) this.advance(name);
  }

  close(): void {
    this.isClosed = true;
    for (const owner of this.owners.values()) owner.running?.abort.abort();
    this.owners.clear();
    this.cells.clear();
    this.volume.close();
  }

  private isUnderWay(cell: Cell): boolean {
    const key = cellKey(cell);
    return [...this.owners.values()].some((owner) => owner.running?.keys.has(key));
  }

  private advance(name: string): void {
    const owner = this.owners.get(name);
    if (this.isClosed || this.failure || !owner || owner.running) return;
    for (const step of owner.steps) {
      const cells = step.cells.filter((cell) => !this.has(cell) && !this.isUnderWay(cell));
      if (cells.length === 0) continue;
      void this.run(owner, { level: step.level, cells });
      return;
    }
  }

  private async run(owner: Owner, step: Step): Promise<void> {
    const running: Running = {
      keys: new Set(step.cells.map(cellKey)),
      level: step.level,
      box: boxAround(this.volume, step),
      abort: new AbortController(),
    };
    owner.running = running;
    try {
      await this.readBox(step, running.box, running);
    } catch (error) {
      if (running.abort.signal.aborted || this.isClosed) return;
      owner.running = undefined;
      // The volume was closed by who opens it again.
      if ((error as Error).name === "AbortError") return;
      this.failure = error as Error;
      this.onFailure(this.failure);
      return;
    }
    if (running.abort.signal.aborted || this.isClosed) return;
    owner.running = undefined;
    // Others may have waited for these cells, or lost theirs to them.
    for (const other of this.owners.keys()) this.advance(other);
  }

  private async readBox(step: Step, box: Box, running: Running): Promise<void> {
    const size = boxSize(box);
    const parts = size[0] * size[1] * size[2] > MOST_VOXELS ? halves(box, 64) : undefined;
    if (parts) {
      for (const part of parts) await this.readBox(step, part, running);
      return;
    }
    const voxels = await this.volume.read(step.level, box, running.abort.signal);
    if (running.abort.signal.aborted || this.isClosed) return;
    const level = this.volume.facts.levels[step.level]!;
    for (const cell of cellsOf(step.level, box)) {
      if (!running.keys.has(cellKey(cell))) continue;
      this.keep(cell, cutOut(voxels, box, cellBox(level, cell.at)));
    }
    this.makeRoom();
    this.onChange();
  }

  private keep(cell: Cell, voxels: Voxels): void {
    const key = cellKey(cell);
    if (this.cells.has(key)) return;
    this.cells.set(key, voxels);
    this.bytes += voxels.byteLength;
  }

  /** Throws away what was used longest ago: first what nobody wants, then anything not pinned. */
  private makeRoom(): void {
    if (this.bytes <= this.budgetBytes) return;
    const wanted = new Set<string>();
    for (const owner of this.owners.values()) {
      for (const step of owner.steps) for (const cell of step.cells) wanted.add(cellKey(cell));
    }
    for (const [key, voxels] of this.cells) {
      if (this.bytes <= this.budgetBytes) return;
      if (wanted.has(key) || this.pinned.has(key)) continue;
      this.cells.delete(key);
      this.bytes -= voxels.byteLength;
    }
  }
}
