// A volume of `@octavo/reader`, as the viewer wants it.
import type * as octavo from "@octavo/reader";
import {
  type BlockRanges,
  type Box,
  type Need,
  ReadFailure,
  type Traffic,
  type Vec3,
  type Volume,
  type VolumeFacts,
  type Voxels,
} from "./volume.js";

const REMEDIES: Partial<Record<octavo.ErrorKind, ReadFailure["remedy"]>> = {
  // What a server sent may be sent better another time.
  io: "retry",
  no_ranges: "retry",
  not_octavo: "retry",
  corrupt: "retry",
  truncated: "retry",
  out_of_memory: "retry",
  replaced: "reopen",
};

/** The failures of the reader as the viewer's; an abort stays what it is. */
export function asFailure(error: unknown): unknown {
  if (!(error instanceof Error)) return new ReadFailure(String(error), "none");
  const kind = (error as Partial<octavo.OctavoFailure>).kind;
  if (kind === "cancelled" || kind === "closed" || error.name === "AbortError") {
    return new DOMException(error.message, "AbortError");
  }
  const isDamage = kind === "corrupt" || kind === "truncated";
  const text = isDamage ? `${error.message} (damaged, or not sent as it is)` : error.message;
  return new ReadFailure(text, (kind && REMEDIES[kind]) ?? "none");
}

/** Where nothing says where a volume lies, it lies at 0 along the axes of the body. */
function hasUsualPlace(volume: octavo.Volume): boolean {
  const isSaid =
    (volume.metadata as { place_known?: unknown } | null | undefined)?.place_known === true;
  const isStraight = volume.direction.every((v, i) => v === (i % 4 === 0 ? 1 : 0));
  return !isSaid && isStraight && volume.originMm.every((v) => v === 0);
}

function factsOf(volume: octavo.Volume): VolumeFacts {
  return {
    name: volume.name,
    fileBytes: volume.byteLength,
    kind: volume.kind,
    type: volume.type,
    geometry: {
      origin: volume.originMm,
      spacing: volume.spacingMm,
      direction: volume.direction,
    },
    isSpacingKnown: volume.isSpacingKnown,
    isPlaceKnown: volume.isPlaceKnown && !hasUsualPlace(volume),
    levels: volume.levels.map((level) => ({ size: level.size, factor: level.factor })),
    slope: volume.slope,
    intercept: volume.intercept,
    // The code of UCUM for Hounsfield units, which people call HU.
    unit: volume.unit === "[hnsf'U]" ? "HU" : volume.unit,
    range: [volume.min, volume.max],
    maxError: volume.maxError,
    labels: volume.labels,
  };
}

async function translated<T>(work: Promise<T>): Promise<T> {
  try {
    return await work;
  } catch (error) {
    throw asFailure(error);
  }
}

export class OctavoVolume implements Volume {
  readonly facts: VolumeFacts;

  constructor(private readonly inner: octavo.Volume) {
    this.facts = factsOf(inner);
  }

  get hostNote(): string {
    return this.inner.hostNote;
  }

  read(level: number, box: Box, signal: AbortSignal): Promise<Voxels> {
    // What is coarse is wanted first.
    return translated(this.inner.read(box, level, { signal, priority: level }));
  }

  need(level: number, box: Box): Promise<Need> {
    return translated(this.inner.plan(box, level));
  }

  async ranges(): Promise<BlockRanges> {
    const finest = this.inner.levels[0]!;
    const grid = finest.brickGrid;
    const found = await translated(this.inner.brickRanges({ lo: [0, 0, 0], hi: grid }, 0));
    return { grid, side: finest.brickSide as Vec3, min: found.min, max: found.max };
  }

  traffic(): Traffic {
    const { requests, fetchedBytes } = this.inner.statistics;
    return { requests, bytes: fetchedBytes };
  }

  async reopen(): Promise<Volume> {
    return new OctavoVolume(await translated(this.inner.reopen()));
  }

  close(): void {
    this.inner.close();
  }
}
