// Who decodes boxes of files: workers, or this thread.
import type { Pool, VoxelTypeName } from "../api.js";
import type { PlacedBytes } from "../store/file_bytes.js";
import type { ByteRange } from "../store/ranges.js";
import type { Corners, Engine, OpeningBytes } from "./engine.js";

/** What decoders know of a volume. */
export interface PoolFile {
  readonly number: number;
  readonly opening: OpeningBytes;
  /** Brings bytes that a decoder lacks. */
  supply(ranges: readonly ByteRange[]): Promise<PlacedBytes[]>;
}

export interface JobOptions {
  readonly level: number;
  readonly box: Corners;
  readonly type: VoxelTypeName;
  /** Jobs of one key go to one worker. */
  readonly key: number;
  readonly priority: number;
  readonly signal?: AbortSignal | undefined;
}

export interface DecodedBox {
  readonly voxels: ArrayBuffer;
  readonly ms: number;
}

export interface Decoders extends Pool {
  readonly module: WebAssembly.Module;
  /** An instance for what needs no file. */
  readonly engine: Engine;
  readonly cacheBytes: number;
  /** A number for a new file. */
  register(): number;
  /** Forgets a file; jobs of it that wait are rejected. */
  forget(file: number): void;
  /** Decodes a box. Its bytes are at hand as a rule: a worker that waits for some does nothing. */
  read(file: PoolFile, options: JobOptions): Promise<DecodedBox>;
}
