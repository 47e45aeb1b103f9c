// What page and workers say to each other.
import type { ErrorKind, VoxelTypeName } from "../api.js";
import type { PlacedBytes } from "../store/file_bytes.js";
import type { ByteRange } from "../store/ranges.js";
import type { Corners, OpeningBytes } from "./engine.js";

export type ToWorker =
  | { readonly kind: "start"; readonly module: WebAssembly.Module; readonly isWarming: boolean }
  | { readonly kind: "open"; readonly file: number; readonly opening: OpeningBytes }
  | { readonly kind: "close"; readonly file: number }
  | {
      readonly kind: "read"; readonly job: number; readonly file: number; readonly level: number;
      readonly box: Corners; readonly type: VoxelTypeName;
    }
  /** Those that a job needs; none where there are none to be had: the job ends. */
  | { readonly kind: "bytes"; readonly job: number; readonly parts: readonly PlacedBytes[] | null };

export type FromWorker =
  | { readonly kind: "needs"; readonly job: number; readonly ranges: readonly ByteRange[] }
  | { readonly kind: "voxels"; readonly job: number; readonly voxels: ArrayBuffer;
      readonly ms: number }
  | { readonly kind: "failed"; readonly job: number; readonly error: ErrorKind;
      readonly message: string };

export const bytesPerVoxel: Record<VoxelTypeName, number> = {
  int8: 1, uint8: 1, int16: 2, uint16: 2, int32: 4, uint32: 4, float32: 4 };
