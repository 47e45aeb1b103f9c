// .8vo files in niivue, which takes whole volumes: a level that fits, as a NIfTI file in memory.
//
//     import { loadNifti } from "@octavo/reader/niivue";
//     const nifti = await loadNifti("scan.8vo");
//     await nv.loadFromArrayBuffer(nifti, "scan.nii");
//     nv.useLoader(loadBytes, "8vo", "nii");          // for loadVolumes, and files dropped on it
import type { OpenOptions, Source, Vector3, Volume, VoxelTypeName } from "../api.js";
import { OctavoError } from "../errors.js";
import { open } from "../volume/opening.js";

export interface NiftiOptions extends OpenOptions {
  /** The level to take; the finest one within mostVoxels where absent. */
  readonly level?: number;
  /** 2^26 where absent: what graphics cards of all kinds take. */
  readonly mostVoxels?: number;
}

const headerBytes = 352;
/** Codes of NIfTI-1 by type. */
const codes: Record<VoxelTypeName, number> = {
  uint8: 2, int16: 4, int32: 8, float32: 16, int8: 256, uint16: 512, uint32: 768 };
const millimeters = 2;
const scannerPlace = 1;

/** A level of a file as the bytes of a NIfTI-1 file. */
export async function loadNifti(
  source: Source, options: NiftiOptions = {}): Promise<ArrayBuffer> {
  const scan = await open(source, options);
  try {
    return await niftiOf(scan, options.level ?? levelWithin(scan, options.mostVoxels ?? 2 ** 26),
      options.signal);
  } finally {
    scan.close();
  }
}

/** For nv.useLoader(loadBytes, "8vo", "nii"): the bytes of a whole file. */
export const loadBytes = (bytes: ArrayBuffer): Promise<ArrayBuffer> => loadNifti(bytes);

function levelWithin(scan: Volume, mostVoxels: number): number {
  const fits = scan.levels.find(({ size }) => size[0] * size[1] * size[2] <= mostVoxels);
  return (fits ?? scan.levels.at(-1)!).level;
}

/** The place in a body, turned from LPS to RAS. */
function setPlace(view: DataView, scan: Volume, spacingMm: Vector3, originMm: Vector3): void {
  view.setInt16(254, scannerPlace, true);
  for (let row = 0; row < 3; ++row) {
    const turn = row < 2 ? -1 : 1;
    for (let axis = 0; axis < 3; ++axis) {
      const step = turn * scan.direction[3 * row + axis]! * spacingMm[axis]!;
      view.setFloat32(280 + 16 * row + 4 * axis, step, true);
    }
    view.setFloat32(280 + 16 * row + 12, turn * originMm[row]!, true);
  }
}

/** A level of an open file. Axes and places are turned from LPS to RAS, as NIfTI has them. */
export async function niftiOf(
  scan: Volume, level: number, signal?: AbortSignal): Promise<ArrayBuffer> {
  const ladder = scan.levels[level];
  if (!ladder) throw new OctavoError("invalid_argument", `${scan.name}: no level ${level}`);
  const { size, spacingMm, originMm } = ladder;
  // NIfTI-1 has 16 bits for a size.
  if (size.some((n) => n > 32767)) {
    throw new OctavoError("limit_exceeded",
      `${scan.name}: level ${level} is ${size.join(" x ")}; NIfTI takes 32767 along an axis`);
  }
  const voxels = await scan.read({ lo: [0, 0, 0], hi: size }, level, signal ? { signal } : {});
  const file = new ArrayBuffer(headerBytes + voxels.byteLength);
  const view = new DataView(file);
  const bytes = voxels.BYTES_PER_ELEMENT;
  view.setInt32(0, 348, true);
  [3, ...size, 1, 1, 1, 1].forEach((n, i) => view.setInt16(40 + 2 * i, n, true));
  view.setInt16(70, codes[scan.type], true);
  view.setInt16(72, 8 * bytes, true);
  [1, ...spacingMm, 1, 1, 1, 1].forEach((n, i) => view.setFloat32(76 + 4 * i, n, true));
  view.setFloat32(108, headerBytes, true);
  view.setFloat32(112, scan.slope, true);
  view.setFloat32(116, scan.intercept, true);
  view.setUint8(123, millimeters);
  if (scan.isPlaceKnown) setPlace(view, scan, spacingMm, originMm);
  [0x6e, 0x2b, 0x31, 0].forEach((byte, i) => view.setUint8(344 + i, byte));
  new Uint8Array(file, headerBytes).set(new Uint8Array(voxels.buffer));
  return file;
}
