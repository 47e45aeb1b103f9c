// What `@octavo/reader` promises: the types of its public functions. No code.
//
// Everything is in the order x, y, z; boxes are half-open and counted in samples of their level.
// Arrays of voxels are dense [z][y][x], x fastest. World coordinates are LPS, in mm.

export type Vector3 = readonly [x: number, y: number, z: number];

/** Samples lo <= (x, y, z) < hi of one level. */
export interface Box {
  readonly lo: Vector3;
  readonly hi: Vector3;
}

export type VoxelTypeName =
  | "int8" | "uint8" | "int16" | "uint16" | "int32" | "uint32" | "float32";

/** The array that holds voxels of a type. */
export interface VoxelArrays {
  int8: Int8Array<ArrayBuffer>;
  uint8: Uint8Array<ArrayBuffer>;
  int16: Int16Array<ArrayBuffer>;
  uint16: Uint16Array<ArrayBuffer>;
  int32: Int32Array<ArrayBuffer>;
  uint32: Uint32Array<ArrayBuffer>;
  float32: Float32Array<ArrayBuffer>;
}
export type VoxelArray = VoxelArrays[VoxelTypeName];

/**
 * - invalid_argument     a box or level that the volume does not have; a source or option that is
 *                        none
 * - not_octavo           the bytes are no .8vo file
 * - unsupported_version  of a later version
 * - corrupt, truncated   damaged: the message names what and where
 * - limit_exceeded       larger than this reader takes
 * - io                   the server or disk failed, after all tries
 * - no_ranges            the server ignores ranges, and the file is too large to fetch whole
 * - replaced             another file stands there now: reopen()
 * - cancelled            the caller's AbortSignal
 * - closed               the volume or the pool was closed
 * - out_of_memory, internal
 */
export type ErrorKind =
  | "invalid_argument" | "not_octavo" | "unsupported_version" | "corrupt" | "truncated"
  | "limit_exceeded" | "io" | "no_ranges" | "replaced" | "cancelled" | "closed"
  | "out_of_memory" | "internal";

/** Every failure of this package: one sentence in `message`. Show it as text, never as HTML. */
export interface OctavoFailure extends Error {
  readonly kind: ErrorKind;
  /** What the server answered, where that is why: 404 for example. */
  readonly status?: number;
}

/** Bytes of a file from anywhere. */
export interface ByteFetcher {
  /** What to call the file in messages. */
  readonly name: string;
  /**
   * The bytes [offset, offset + length), fewer only where the file ends.
   * Rejects with the signal's reason when that aborts.
   */
  fetchBytes(offset: number, length: number, signal: AbortSignal): Promise<Uint8Array>;
}

/** A URL as text or object, a File or Blob, bytes in memory, or a fetcher. */
export type Source = string | URL | Blob | ArrayBuffer | Uint8Array | ByteFetcher;

/** A server that has brought less than 100 kB a second for five seconds, though more is wanted. */
export interface SlowServer {
  /** Of the requests under way. */
  readonly arrivedBytes: number;
  /** All that they ask for; NaN where the server does not say how much it sends. */
  readonly wantedBytes: number;
  /** Since the oldest of them was sent. */
  readonly seconds: number;
  /** Ends these requests and sends them anew. */
  askAgain(): void;
}

export interface OpenOptions {
  /** Gives up opening. A volume that is open is ended by close(). */
  readonly signal?: AbortSignal;
  /** What to call the file in messages; a URL or file name where absent. */
  readonly name?: string;
  /** Who decodes; a shared pool where absent. */
  readonly pool?: Pool;
  /** Fetched bytes kept at most, 128 MiB where absent. */
  readonly cacheBytes?: number;
  /** Requests under way at a time, 6 where absent: what browsers do for one HTTP/1.1 host. */
  readonly parallelRequests?: number;
  /** Holes up to so many bytes are fetched along rather than asked around, 32 KiB where absent. */
  readonly joinGapBytes?: number;
  /** Of a server that ignores ranges, a file up to here is fetched whole; 50 MB where absent. */
  readonly wholeFileBytes?: number;
  /** Called about once a second while the server is slow, and with null once it no longer is. */
  readonly onSlow?: (slow: SlowServer | null) => void;
  /** Sends cookies and the like to another origin; "omit" where absent. */
  readonly credentials?: "omit" | "same-origin" | "include";
}

/** WebAssembly.Module, where the types of the program that uses this know it. */
export type CompiledModule = typeof globalThis extends
  { WebAssembly: { Module: { prototype: infer Module } } } ? Module : never;

export interface PoolOptions {
  /** Workers that decode; cores less one, at most 8, where absent. 0: on the calling thread. */
  readonly workers?: number;
  /** Decoded bricks that each worker keeps at most, 32 MiB of each volume where absent. */
  readonly cacheBytes?: number;
  /**
   * Where octavo.wasm is, or the compiled module; beside this script where absent. Text counts from
   * the page; in Node.js it may be a path.
   */
  readonly wasm?: string | URL | CompiledModule;
  /** Where worker.js is, of Node.js worker-node.js; as for wasm. */
  readonly worker?: string | URL;
}

/** Workers that decode, each with an instance of its own. Serves any number of volumes. */
export interface Pool {
  readonly workers: number;
  /** Ends the workers; what waits for them rejects with kind closed. */
  close(): void;
}

export interface ReadOptions {
  readonly signal?: AbortSignal;
  /** Higher goes first, at the network and at the workers; 0 where absent. */
  readonly priority?: number;
}

/** One rung of the ladder. Level 0 is the scan. */
export interface Level {
  readonly level: number;
  readonly size: Vector3;
  readonly spacingMm: Vector3;
  /** World position of the center of sample (0, 0, 0). */
  readonly originMm: Vector3;
  /** Voxels of level 0 along each axis that one sample stands for: powers of two. */
  readonly factor: Vector3;
  /** Samples of a full brick: what is decoded at once. Boxes of whole bricks waste nothing. */
  readonly brickSide: Vector3;
  /** Bricks along each axis. */
  readonly brickGrid: Vector3;
  /** Coded bytes that begin with this level's; 0 where they stand within those of a finer one. */
  readonly byteLength: number;
}

export interface LabelInfo {
  readonly label: number;
  /** Text from the file: show it as text, never as HTML. */
  readonly name: string;
  /** Red, green, blue, 0 to 255. */
  readonly color: readonly [number, number, number];
}

/** Fidelity in numbers: what a box at a level needs, and what of it is here. */
export interface Plan {
  readonly level: number;
  /** False while parts of bricks are not known yet: the box needs more than what follows. */
  readonly isComplete: boolean;
  /** Coded bytes that the box needs. */
  readonly neededBytes: number;
  /** Those of them that need not be fetched any more. */
  readonly presentBytes: number;
  /** Requests that fetching the rest takes, and their bytes with the holes between. */
  readonly requests: number;
  readonly requestBytes: number;
  /** Bricks that the box meets, and those of them that are one value throughout: no bytes. */
  readonly bricks: number;
  readonly uniformBricks: number;
}

/** Smallest and largest voxel of bricks, from the index alone: [z][y][x] of those asked for. */
export interface BrickRanges {
  /** In bricks. */
  readonly box: Box;
  readonly min: Float64Array;
  readonly max: Float64Array;
}

/** Since the volume was opened. */
export interface Statistics {
  /** Requests sent, those repeated among them. */
  readonly requests: number;
  readonly retries: number;
  /** Bytes of the file that arrived. */
  readonly fetchedBytes: number;
  /** Bytes held of them. */
  readonly cachedBytes: number;
  readonly pendingRequests: number;
  /** Voxels handed out, and the time of workers that they took. */
  readonly voxels: number;
  readonly decodeMs: number;
}

/** What a file says of its voxels. */
export interface FileFacts {
  /** 16 hexadecimal digits: equal for byte-identical builds, different for different files. */
  readonly buildId: string;
  /** "1.0" */
  readonly formatVersion: string;
  readonly kind: "grey" | "labels";
  readonly type: VoxelTypeName;
  readonly size: Vector3;
  readonly levels: readonly Level[];
  readonly spacingMm: Vector3;
  readonly originMm: Vector3;
  /** Row-major 3x3; column a is the unit vector of index axis a in LPS. */
  readonly direction: readonly number[];
  /** False when the source carried no spacing and 1 mm was assumed. */
  readonly isSpacingKnown: boolean;
  /** False when origin and direction do not place the volume in a body: no letters L, P, S then. */
  readonly isPlaceKnown: boolean;
  /** real value = slope * voxel + intercept */
  readonly slope: number;
  readonly intercept: number;
  /** Of real values: a code of UCUM or any text, "HU" for example; empty where not known. */
  readonly unit: string;
  /** Smallest and largest voxel; bounds where lossy. */
  readonly min: number;
  readonly max: number;
  /** No voxel of level 0 differs from its source by more, voxel units; 0 is lossless. */
  readonly maxError: number;
  /** The finest level that has details; finer ones are interpolated from it. */
  readonly detailLevel: number;
}

/** An opened file. Every function may be called at any time, by several callers at once. */
export interface Volume extends FileFacts {
  readonly name: string;
  readonly byteLength: number;
  /** The labels that the file names, by number; empty of grey volumes. */
  readonly labels: ReadonlyMap<number, LabelInfo>;
  /** The JSON text that stands in the file, and its value: null where it is no JSON. */
  readonly metadataText: string;
  readonly metadata: unknown;
  /** A sentence about the host when the file had to be fetched whole; empty otherwise. */
  readonly hostNote: string;
  readonly statistics: Statistics;

  /**
   * The voxels of a box at a level, [z][y][x]. Fetches what is missing in joined requests, decodes
   * in the pool. Rejects with OctavoFailure; nothing is ever filled in for what cannot be read.
   */
  read(box: Box, level: number, options?: ReadOptions): Promise<VoxelArray>;
  /** The same as real values: slope * voxel + intercept. */
  readReal(box: Box, level: number, options?: ReadOptions): Promise<Float32Array>;
  /** What read() would need, and how much of it is here. Fetches pages of the index alone. */
  plan(box: Box, level: number, options?: ReadOptions): Promise<Plan>;
  /** Ranges of the bricks of a level's tier: what is empty can be skipped without a byte of it. */
  brickRanges(bricks: Box, level: number, options?: ReadOptions): Promise<BrickRanges>;

  /** The real value of a voxel. */
  toReal(voxel: number): number;
  /** Position in mm (LPS) of a sample of a level, fractions allowed; and back. */
  toWorld(index: Vector3, level?: number): Vector3;
  toIndex(worldMm: Vector3, level?: number): Vector3;
  /** The coarsest level whose samples are no farther apart than that along any axis that counts. */
  levelFor(spacingMm: number): number;
  /** The name, or the number where it has none, and the color of any label. */
  labelInfo(label: number): LabelInfo;
  /** The o-code of the cube of side 2^level around a voxel of level 0, digits and markers; level
   *  0 to that of the smallest such cube that holds the whole. */
  oCode(voxel: Vector3, level?: number): string;
  /** The PNG picture that the file carries; null when it has none. */
  thumbnail(options?: ReadOptions): Promise<Blob | null>;

  /** Opens what stands at the source now; this volume is closed. */
  reopen(options?: ReadOptions): Promise<Volume>;
  /** Ends all requests and forgets all bytes; what waits rejects with kind closed. */
  close(): void;
}

/** Opens a file: two requests as a rule. Rejects with OctavoFailure. */
export type Open = (source: Source, options?: OpenOptions) => Promise<Volume>;

/** Compiles the module once and starts workers, which are warm before the first voxel is wanted. */
export type CreatePool = (options?: PoolOptions) => Promise<Pool>;
