// A volume of stored voxels in memory, from a headerless file.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/volume.h"
#include "octavo/core/voxel_type.h"

namespace octavo::bench {

using Bytes = std::vector<std::uint8_t>;

struct RawVolume {
  std::string name;
  VolumeKind kind = VolumeKind::grey;
  VoxelType type = VoxelType::uint8;
  Size3 size;
  Point3 spacing_mm = {1, 1, 1};
  Bytes voxels;        ///< [z][y][x], little-endian
  ValueRange range;    ///< smallest and largest voxel; integers only

  std::int64_t voxel_bytes() const { return bytes_per_voxel(type); }
  std::int64_t plane_bytes() const { return size.x * size.y * voxel_bytes(); }
};

/// The volume of a line "NAME PATH nx,ny,nz,type [grey|labels] [sx,sy,sz]".
/// Throws Error{source_rejected} when the file's length is not that of the layout.
RawVolume load_raw_volume(const std::string& line);

/// Plane z as unsigned samples counted from the smallest voxel. Requires range.max - range.min <=
/// 65535.
std::vector<std::uint16_t> plane_samples(const RawVolume& volume, std::int64_t z);

/// Writes `samples` back as plane z of `volume`, the inverse of plane_samples.
void put_plane_samples(RawVolume& volume, std::int64_t z,
                       const std::vector<std::uint16_t>& samples);

/// Bits that hold every sample of plane_samples, at least 1.
int sample_bits(const RawVolume& volume);

}  // namespace octavo::bench
