// NIfTI-1 files of 16-bit voxels.

/** real = slope * voxel + intercept; voxels x fastest, spacing in mm. */
export function niftiBytes(voxels, size, spacing, slope, intercept) {
  const header = Buffer.alloc(352);
  header.writeInt32LE(348, 0);
  [3, ...size, 1, 1, 1, 1].forEach((n, i) => header.writeInt16LE(n, 40 + 2 * i));
  header.writeInt16LE(4, 70); // 16 bits with a sign
  header.writeInt16LE(16, 72);
  [1, ...spacing].forEach((mm, i) => header.writeFloatLE(mm, 76 + 4 * i));
  header.writeFloatLE(352, 108);
  header.writeFloatLE(slope, 112);
  header.writeFloatLE(intercept, 116);
  header[123] = 2; // mm
  header.writeInt16LE(1, 254); // rows of a matrix; x and y against those of LPS
  spacing.forEach((mm, row) => header.writeFloatLE(row < 2 ? -mm : mm, 280 + 16 * row + 4 * row));
  header.write("n+1\0", 344, "latin1");
  return Buffer.concat([header, Buffer.from(voxels.buffer, voxels.byteOffset, voxels.byteLength)]);
}
