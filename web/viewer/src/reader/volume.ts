// What the viewer needs of a volume, and nothing of how it comes: a file behind a URL, a dropped
// file, or a volume made up by a test.

export type Vec3 = readonly [number, number, number];
export type Axis = 0 | 1 | 2;
export const AXES: readonly Axis[] = [0, 1, 2];

export type VoxelType = "int8" | "uint8" | "int16" | "uint16" | "int32" | "uint32" | "float32";
export type Voxels =
  Int8Array | Uint8Array | Int16Array | Uint16Array | Int32Array | Uint32Array | Float32Array;

/** Half-open: samples lo .. hi - 1 of a level along x, y and z. */
export interface Box {
  readonly lo: Vec3;
  readonly hi: Vec3;
}

/** world = origin + direction * (spacing .* index); LPS, mm; index counts voxel centers. */
export interface Geometry {
  readonly origin: Vec3;
  readonly spacing: Vec3;
  /** Row-major 3 x 3; column a is the unit vector of index axis a. */
  readonly direction: readonly number[];
}

export interface Level {
  readonly size: Vec3;
  /** Voxels of level 0 that a sample stands for along each axis: powers of two. */
  readonly factor: Vec3;
}

export interface LabelEntry {
  readonly name: string;
  /** 0 .. 255 each; absent where the file names none. */
  readonly color?: Vec3;
}

export interface VolumeFacts {
  readonly name: string;
  readonly fileBytes: number;
  readonly kind: "grey" | "labels";
  readonly type: VoxelType;
  readonly geometry: Geometry;
  readonly isSpacingKnown: boolean;
  /** Whether origin and direction place the volume in a body. */
  readonly isPlaceKnown: boolean;
  readonly levels: readonly Level[];
  /** real = slope * stored + intercept */
  readonly slope: number;
  readonly intercept: number;
  readonly unit: string;
  /** Smallest and largest stored voxel, or bounds of them. */
  readonly range: readonly [number, number];
  /** No voxel differs from its source by more, stored units; 0 is lossless. */
  readonly maxError: number;
  readonly labels: ReadonlyMap<number, LabelEntry>;
}

/** What was asked of the server so far. */
export interface Traffic {
  readonly requests: number;
  readonly bytes: number;
}

/** A server that brings less than what is asked of it, for some seconds now. */
export interface SlowServer {
  readonly arrivedBytes: number;
  /** NaN where the server does not say. */
  readonly wantedBytes: number;
  readonly seconds: number;
  /** Ends the requests under way and sends them anew. */
  askAgain(): void;
}

/** Coded bytes of a box: how many it needs, and how many of them are here. */
export interface Need {
  readonly neededBytes: number;
  readonly presentBytes: number;
}

/** Smallest and largest stored voxel of blocks of level 0, x fastest, from the index alone. */
export interface BlockRanges {
  readonly grid: Vec3;
  /** Voxels of level 0 along each side of a block. */
  readonly side: Vec3;
  readonly min: Float64Array;
  readonly max: Float64Array;
}

/**
 * Why a volume could not be read: one sentence for people, and what may be done about it.
 * retry: the server failed; reopen: another file stands there now; none: no try will help.
 */
export class ReadFailure extends Error {
  constructor(
    message: string,
    readonly remedy: "retry" | "reopen" | "none",
  ) {
    super(message);
    this.name = "ReadFailure";
  }
}

export interface Volume {
  readonly facts: VolumeFacts;
  /** A sentence about the host, or nothing. */
  readonly hostNote: string;
  /**
   * The voxels of a box of samples of a level: x fastest, then y, then z.
   * Rejects with a ReadFailure, or with an AbortError once `signal` is aborted.
   */
  read(level: number, box: Box, signal: AbortSignal): Promise<Voxels>;
  need(level: number, box: Box): Promise<Need>;
  ranges(): Promise<BlockRanges>;
  traffic(): Traffic;
  /** What stands at the same place now; this volume is closed. */
  reopen(): Promise<Volume>;
  close(): void;
}
