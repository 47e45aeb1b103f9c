#include "bench/common/raw_volume.h"

#include <algorithm>
#include <bit>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo::bench {
namespace {

template <class T>
ValueRange range_of(const Bytes& voxels) {
  ValueRange range{std::numeric_limits<T>::max(), std::numeric_limits<T>::lowest()};
  for (std::size_t at = 0; at + sizeof(T) <= voxels.size(); at += sizeof(T)) {
    T value;
    std::memcpy(&value, voxels.data() + at, sizeof value);
    range.min = std::min(range.min, static_cast<std::int64_t>(value));
    range.max = std::max(range.max, static_cast<std::int64_t>(value));
  }
  return range;
}

ValueRange range_of(VoxelType type, const Bytes& voxels) {
  return with_voxel_type(type, [&]<class T>(std::type_identity<T>) -> ValueRange {
    if constexpr (std::is_integral_v<T>) return range_of<T>(voxels);
    throw Error(ErrorKind::invalid_argument, "the benchmarks take integer voxels only");
  });
}

[[noreturn]] void reject(const std::string& line) {
  throw Error(ErrorKind::invalid_argument,
              "expected NAME PATH nx,ny,nz,type [grey|labels] [sx,sy,sz], found: " + escaped(line));
}

void parse_layout(RawVolume& volume, const std::string& layout, const std::string& line) {
  long long x = 0, y = 0, z = 0;
  char type[16] = {};
  if (std::sscanf(layout.c_str(), "%lld,%lld,%lld,%15s", &x, &y, &z, type) != 4) reject(line);
  const auto parsed = parse_voxel_type(type);
  if (!parsed) reject(line);
  volume.type = *parsed;
  volume.size = {x, y, z};
}

}  // namespace

RawVolume load_raw_volume(const std::string& line) {
  std::istringstream words(line);
  RawVolume volume;
  std::string path, layout, kind, spacing;
  if (!(words >> volume.name >> path >> layout)) reject(line);
  words >> kind >> spacing;
  parse_layout(volume, layout, line);
  if (kind == "labels") volume.kind = VolumeKind::labels;
  if (!spacing.empty() && std::sscanf(spacing.c_str(), "%lf,%lf,%lf", &volume.spacing_mm[0],
                                      &volume.spacing_mm[1], &volume.spacing_mm[2]) != 3) {
    reject(line);
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(ErrorKind::io, "cannot be opened", path);
  volume.voxels.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  const auto expected =
      static_cast<std::uint64_t>(checked_voxel_count(volume.size) * volume.voxel_bytes());
  if (volume.voxels.size() != expected) {
    throw Error(ErrorKind::source_rejected,
                "holds " + std::to_string(volume.voxels.size()) + " bytes, expected " +
                    std::to_string(expected), path);
  }
  volume.range = range_of(volume.type, volume.voxels);
  return volume;
}

std::vector<std::uint16_t> plane_samples(const RawVolume& volume, std::int64_t z) {
  const auto count = static_cast<std::size_t>(volume.size.x * volume.size.y);
  std::vector<std::uint16_t> samples(count);
  const std::uint8_t* plane = volume.voxels.data() + z * volume.plane_bytes();
  with_voxel_type(volume.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < count; ++i) {
      T value;
      std::memcpy(&value, plane + i * sizeof(T), sizeof(T));
      samples[i] = static_cast<std::uint16_t>(static_cast<std::int64_t>(value) - volume.range.min);
    }
  });
  return samples;
}

void put_plane_samples(RawVolume& volume, std::int64_t z,
                       const std::vector<std::uint16_t>& samples) {
  std::uint8_t* plane = volume.voxels.data() + z * volume.plane_bytes();
  with_voxel_type(volume.type, [&]<class T>(std::type_identity<T>) {
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto value = static_cast<T>(volume.range.min + samples[i]);
      std::memcpy(plane + i * sizeof(T), &value, sizeof(T));
    }
  });
}

int sample_bits(const RawVolume& volume) {
  const auto span = static_cast<std::uint64_t>(volume.range.max - volume.range.min);
  return std::max(1, static_cast<int>(std::bit_width(span)));
}

}  // namespace octavo::bench
