// A volume that is computed: a head of shells, with marks at known voxels. Stands in for a file.
import {
  AXES,
  type BlockRanges,
  type Box,
  type Level,
  type Need,
  ReadFailure,
  type Traffic,
  type Vec3,
  type Volume,
  type VolumeFacts,
  type VoxelType,
  type Voxels,
} from "../src/reader/volume.js";

export interface MadeUp {
  readonly size?: Vec3;
  readonly spacing?: Vec3;
  readonly kind?: "grey" | "labels";
  readonly name?: string;
  readonly delayMs?: number;
  /** Gives a failure for some reads. */
  readonly fail?: (level: number) => ReadFailure | undefined;
}

/** HU-like values: air, skin, skull, brain with a bright ball. */
export function valueOf(size: Vec3, x: number, y: number, z: number): number {
  const at = [x, y, z].map((v, a) => (2 * v + 1) / size[a as 0]! - 1) as [number, number, number];
  const r = Math.hypot(at[0] * 1.1, at[1], at[2] * 1.05);
  const ball = Math.hypot(at[0] - 0.25, at[1] + 0.1, at[2] - 0.2);
  if (r > 0.9) return -1000;
  if (r > 0.82) return 40;
  if (r > 0.7) return 900;
  return ball < 0.2 ? 90 : Math.round(30 + 8 * Math.sin(12 * at[0]) * Math.cos(9 * at[1]));
}

export function labelOf(size: Vec3, x: number, y: number, z: number): number {
  const value = valueOf(size, x, y, z);
  return value === 900 ? 1 : value === 90 ? 2 : value > -1000 && value !== 40 ? 3 : 0;
}

function levelsOf(size: Vec3): Level[] {
  const levels: Level[] = [{ size, factor: [1, 1, 1] }];
  while (levels.at(-1)!.size.some((n) => n > 1)) {
    const last = levels.at(-1)!;
    levels.push({
      size: last.size.map((n) => Math.ceil(n / 2)) as unknown as Vec3,
      factor: last.factor.map((n) => n * 2) as unknown as Vec3,
    });
  }
  return levels;
}

export class MadeUpVolume implements Volume {
  readonly facts: VolumeFacts;
  readonly hostNote = "";
  readonly reads: { level: number; box: Box }[] = [];
  private bytes = 0;

  constructor(private readonly options: MadeUp = {}) {
    const size = options.size ?? [96, 112, 80];
    const kind = options.kind ?? "grey";
    this.facts = {
      name: options.name ?? "made up.8vo",
      fileBytes: size[0] * size[1] * size[2],
      kind,
      type: (kind === "grey" ? "int16" : "uint8") satisfies VoxelType,
      geometry: {
        origin: [-50, -60, 10],
        spacing: options.spacing ?? [1, 1, 1.5],
        direction: [1, 0, 0, 0, 1, 0, 0, 0, 1],
      },
      isSpacingKnown: true,
      isPlaceKnown: true,
      levels: levelsOf(size),
      slope: 1,
      intercept: 0,
      unit: kind === "grey" ? "HU" : "",
      range: kind === "grey" ? [-1000, 900] : [0, 3],
      maxError: 0,
      labels: new Map(
        kind === "grey"
          ? []
          : [
              [1, { name: "skull" }],
              [2, { name: "<img src=x onerror=alert(1)>" }],
              [3, { name: "brain", color: [240, 160, 170] as const }],
            ],
      ),
    };
  }

  private sample(level: Level, x: number, y: number, z: number): number {
    const { size } = this.facts.levels[0]!;
    const at = [x, y, z].map((v, a) =>
      Math.min(size[a as 0]! - 1, Math.floor((v + 0.5) * level.factor[a as 0]!)),
    ) as [number, number, number];
    return this.facts.kind === "grey" ? valueOf(size, ...at) : labelOf(size, ...at);
  }

  async read(number: number, box: Box, signal: AbortSignal): Promise<Voxels> {
    this.reads.push({ level: number, box });
    await new Promise((resolve) => setTimeout(resolve, this.options.delayMs ?? 0));
    if (signal.aborted) throw new DOMException("aborted", "AbortError");
    const failure = this.options.fail?.(number);
    if (failure) throw failure;
    const level = this.facts.levels[number]!;
    const n = AXES.map((a) => box.hi[a] - box.lo[a]) as [number, number, number];
    const out =
      this.facts.kind === "grey"
        ? new Int16Array(n[0] * n[1] * n[2])
        : new Uint8Array(n[0] * n[1] * n[2]);
    let to = 0;
    for (let z = box.lo[2]; z < box.hi[2]; ++z) {
      for (let y = box.lo[1]; y < box.hi[1]; ++y) {
        for (let x = box.lo[0]; x < box.hi[0]; ++x) out[to++] = this.sample(level, x, y, z);
      }
    }
    this.bytes += out.byteLength;
    return out;
  }

  async need(_level: number, box: Box): Promise<Need> {
    return {
      neededBytes: AXES.reduce<number>((n, a) => n * (box.hi[a] - box.lo[a]), 1),
      presentBytes: 0,
    };
  }

  async ranges(): Promise<BlockRanges> {
    const { size } = this.facts.levels[0]!;
    const grid = size.map((n) => Math.ceil(n / 64)) as unknown as Vec3;
    const count = grid[0] * grid[1] * grid[2];
    const min = new Float64Array(count).fill(Infinity);
    const max = new Float64Array(count).fill(-Infinity);
    for (let z = 0; z < size[2]; ++z) {
      for (let y = 0; y < size[1]; ++y) {
        for (let x = 0; x < size[0]; ++x) {
          const i = ((z >> 6) * grid[1] + (y >> 6)) * grid[0] + (x >> 6);
          const v = this.sample(this.facts.levels[0]!, x, y, z);
          min[i] = Math.min(min[i]!, v);
          max[i] = Math.max(max[i]!, v);
        }
      }
    }
    return { grid, side: [64, 64, 64], min, max };
  }

  traffic(): Traffic {
    return { requests: this.reads.length, bytes: this.bytes };
  }

  async reopen(): Promise<Volume> {
    return new MadeUpVolume({ ...this.options, name: "opened again.8vo" });
  }

  close(): void {}
}
