// An opened volume with what belongs to it: its cells, and labels that lie over it.
import { AXES, type Axis, type Vec3, type Volume, type Voxels } from "../reader/volume.js";
import { CELL_SIDE, boxSize, cellBox, cellsOf, previewLevel, wholeBox } from "../decode/cells.js";
import { CellStore, type Step } from "../decode/cell_store.js";
import { type Orientation, sampleAt, toIndex, toWorld } from "../view/geometry.js";
import { NOT_A_NUMBER, type Plane, planeBox, planeOfBox, planeRect } from "../view/slice_plane.js";
import { type Window, robustWindow, wholeWindow } from "../view/window.js";

/** A value as it is known so far: the finest level of which the voxel is here. */
export interface KnownValue {
  readonly stored: number;
  readonly level: number;
}

const PREVIEW = "preview";

export class Session {
  readonly preview: number;
  readonly cells: CellStore;
  first: { readonly axis: Axis; readonly plane: Plane } | undefined;
  private readonly opening = new AbortController();

  constructor(
    readonly volume: Volume,
    budgetBytes: number,
    onChange: () => void,
    onFailure: (error: Error) => void,
  ) {
    this.cells = new CellStore(volume, budgetBytes, onChange, onFailure);
    this.preview = previewLevel(volume.facts.levels);
  }

  get facts(): Volume["facts"] {
    return this.volume.facts;
  }

  private previewStep(): Step {
    const level = this.facts.levels[this.preview]!;
    return { level: this.preview, cells: cellsOf(this.preview, wholeBox(level)) };
  }

  /** Asks for the whole volume as it is shown first. */
  wantPreview(): void {
    const step = this.previewStep();
    this.cells.pin(step.cells);
    this.cells.want(PREVIEW, [step]);
  }

  /**
   * One coarse slice, before all else: of the layers of a file, which are read one by one, it needs
   * the fewest. What goes wrong is met again when the rest is read.
   */
  async readFirst(o: Orientation, voxel: number): Promise<void> {
    const { levels } = this.facts;
    const last = levels[0]!.size;
    const all = { lo: [0, 0] as const, hi: [last[o.across] - 1, last[o.down] - 1] as const };
    const rect = planeRect(levels, this.preview, o, voxel, all);
    try {
      const box = planeBox(o, rect);
      const voxels = await this.volume.read(this.preview, box, this.opening.signal);
      this.first = { axis: o.axis, plane: planeOfBox(this.facts, o, rect, voxels) };
    } catch {
      this.first = undefined;
    }
  }

  get hasPreview(): boolean {
    return this.cells.hasAll(this.previewStep());
  }

  /** The window of what is shown first; of the range of values before that is here. */
  autoWindow(): Window {
    const real = (v: number): number => v * this.facts.slope + this.facts.intercept;
    if (!this.hasPreview && this.first) {
      const { values } = this.first.plane;
      return robustWindow(values.filter((v) => v > NOT_A_NUMBER).map(real));
    }
    if (!this.hasPreview) {
      const [a, b] = this.facts.range.map(real) as [number, number];
      return wholeWindow(Math.min(a, b), Math.max(a, b));
    }
    const values: number[] = [];
    for (const cell of this.previewStep().cells) {
      for (const v of this.cells.peek(cell)!) values.push(real(v));
    }
    return robustWindow(values);
  }

  /** Whether the whole volume is known to hold no finite value: coarse samples are so only then. */
  get isNowhereFinite(): boolean {
    if (!this.hasPreview || this.facts.type !== "float32") return false;
    return this.previewStep().cells.every((cell) =>
      this.cells.peek(cell)!.every((v: number) => !Number.isFinite(v)),
    );
  }

  /** Counts of the preview's real values in equal steps of a span. */
  histogram(span: readonly [number, number], bins: number): Float64Array {
    const counts = new Float64Array(bins);
    if (!this.hasPreview) return counts;
    for (const cell of this.previewStep().cells) {
      for (const v of this.cells.peek(cell)!) {
        const share =
          (v * this.facts.slope + this.facts.intercept - span[0]) / (span[1] - span[0]);
        const bin = Math.floor(share * bins);
        if (bin >= 0 && bin < bins) counts[bin]! += 1;
      }
    }
    return counts;
  }

  /** The labels of what is shown first, with the samples of each. */
  labelsSeen(): Map<number, number> {
    const seen = new Map<number, number>();
    if (!this.hasPreview) return seen;
    for (const cell of this.previewStep().cells) {
      for (const label of this.cells.peek(cell)!) seen.set(label, (seen.get(label) ?? 0) + 1);
    }
    seen.delete(0);
    return seen;
  }

  valueAt(voxel: Vec3): KnownValue | undefined {
    for (let level = 0; level <= this.preview; ++level) {
      const of = this.facts.levels[level]!;
      const sample = AXES.map((a) => sampleAt(of, a, voxel[a])) as unknown as Vec3;
      const at = sample.map((s) => Math.floor(s / CELL_SIDE)) as unknown as Vec3;
      const voxels: Voxels | undefined = this.cells.peek({ level, at });
      if (!voxels) continue;
      const box = cellBox(of, at);
      const size = boxSize(box);
      const [x, y, z] = AXES.map((a) => sample[a] - box.lo[a]) as [number, number, number];
      return { stored: voxels[(z * size[1] + y) * size[0] + x]!, level };
    }
    return undefined;
  }

  /** The voxel of level 0 of another volume that lies where a voxel of this one does; undefined
   *  outside it. */
  voxelIn(other: Session, voxel: Vec3): Vec3 | undefined {
    const at = toIndex(other.facts.geometry, toWorld(this.facts.geometry, voxel));
    const rounded = at.map(Math.round) as unknown as Vec3;
    const size = other.facts.levels[0]!.size;
    return AXES.every((a) => rounded[a] >= 0 && rounded[a] < size[a]) ? rounded : undefined;
  }

  close(): void {
    this.opening.abort();
    this.cells.close();
  }
}
