// Ranges of the bytes of a file, and those bytes that are here.
//
// Runs are sorted by offset and do not overlap. When they take too much room, those that were
// asked for longest ago are dropped.

export interface ByteRange {
  readonly offset: number;
  readonly length: number;
}

export const endOf = (range: ByteRange): number => range.offset + range.length;

export const totalLength = (ranges: readonly ByteRange[]): number =>
  ranges.reduce((sum, range) => sum + range.length, 0);

/** The ranges that cover `ranges`, rising; holes of at most `gap` bytes are covered, too. */
export function joined(ranges: readonly ByteRange[], gap: number): ByteRange[] {
  const rising = ranges.filter((range) => range.length > 0).sort((a, b) => a.offset - b.offset);
  const all: { offset: number; length: number }[] = [];
  for (const range of rising) {
    const last = all.at(-1);
    if (last && range.offset - endOf(last) <= gap) {
      last.length = Math.max(last.length, endOf(range) - last.offset);
    } else {
      all.push({ offset: range.offset, length: range.length });
    }
  }
  return all;
}

interface Run {
  readonly offset: number;
  readonly bytes: Uint8Array;
  used: number;
}

export class RangeStore {
  private runs: Run[] = [];
  private clock = 0;
  private held = 0;

  constructor(private mostBytes: number) {}

  get byteLength(): number {
    return this.held;
  }

  /** Keeps those bytes that are not here yet. */
  put(offset: number, bytes: Uint8Array): void {
    for (const gap of this.missing([{ offset, length: bytes.length }])) {
      const own = bytes.subarray(gap.offset - offset, endOf(gap) - offset);
      // A view of a larger array would keep all of it alive.
      const run = {
        offset: gap.offset,
        bytes: own.length === bytes.buffer.byteLength ? own : own.slice(),
        used: ++this.clock,
      };
      this.runs.splice(this.firstFrom(gap.offset), 0, run);
      this.held += own.length;
    }
    this.shrink();
  }

  /** The parts of `ranges` that are not here, rising and apart. */
  missing(ranges: readonly ByteRange[]): ByteRange[] {
    const gaps: ByteRange[] = [];
    for (const range of joined(ranges, 0)) {
      let at = range.offset;
      for (let i = Math.max(0, this.firstFrom(at) - 1); i < this.runs.length; ++i) {
        const run = this.runs[i]!;
        if (run.offset >= endOf(range)) break;
        const end = run.offset + run.bytes.length;
        if (end <= at) continue;
        if (run.offset > at) gaps.push({ offset: at, length: run.offset - at });
        at = end;
      }
      if (at < endOf(range)) gaps.push({ offset: at, length: endOf(range) - at });
    }
    return gaps;
  }

  /** A copy of the bytes of a range; null where some are missing. */
  read(range: ByteRange): Uint8Array<ArrayBuffer> | null {
    const out = new Uint8Array(range.length);
    let at = range.offset;
    for (let i = Math.max(0, this.firstFrom(at + 1) - 1); at < endOf(range); ++i) {
      const run = this.runs[i];
      if (!run || run.offset > at || run.offset + run.bytes.length <= at) return null;
      const own = run.bytes.subarray(at - run.offset, endOf(range) - run.offset);
      out.set(own, at - range.offset);
      run.used = ++this.clock;
      at += own.length;
    }
    return out;
  }

  /** Drops every run that meets one of the ranges. */
  drop(ranges: readonly ByteRange[]): void {
    const isKept = (run: Run) => !ranges.some(
      (range) => run.offset < endOf(range) && range.offset < run.offset + run.bytes.length);
    this.runs = this.runs.filter(isKept);
    this.held = this.runs.reduce((sum, run) => sum + run.bytes.length, 0);
  }

  /** From now on nothing is dropped to make room. */
  keepAll(): void {
    this.mostBytes = Infinity;
  }

  clear(): void {
    this.runs = [];
    this.held = 0;
  }

  /** The number of the first run that begins at `offset` or behind it. */
  private firstFrom(offset: number): number {
    let low = 0;
    let high = this.runs.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.runs[middle]!.offset < offset) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  private shrink(): void {
    if (this.held <= this.mostBytes) return;
    // Down to three quarters, so that this is not done for every run that comes.
    const rising = [...this.runs].sort((a, b) => a.used - b.used);
    const dropped = new Set<Run>();
    for (const run of rising) {
      if (this.held <= this.mostBytes * 0.75) break;
      this.held -= run.bytes.length;
      dropped.add(run);
    }
    this.runs = this.runs.filter((run) => !dropped.has(run));
  }
}
