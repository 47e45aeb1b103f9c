#include "octavo/tasks/files/decoding_memory.h"

#include <algorithm>

#include "octavo/file/reader.h"

namespace octavo {

namespace {

/// The program with its libraries, and what codecs and the directory of a file hold.
constexpr std::uint64_t kProgramBytes = std::uint64_t{8} << 20;

/// Of the largest brick.
constexpr std::int64_t kBrickSide = 64;

/// Of a voxel of a brick, what a thread decodes it in: grids of up to four bricks or parts at the
/// same time, in samples of 16 or 32 bits.
std::uint64_t decoding_bytes_per_voxel(const VolumeDescription& volume) {
  if (volume.kind == VolumeKind::labels) return 16;
  return bytes_per_voxel(volume.type) > 2 ? 200 : 128;
}

/// In what a thread decodes bricks of 64^3 voxels of 16 bits.
constexpr std::uint64_t kUsualThreadBytes = std::uint64_t{32} << 20;

}  // namespace

std::uint64_t cache_bytes(const TaskContext& context) {
  const std::uint64_t most = ReaderOptions().cache_bytes;
  if (context.max_memory_bytes == 0) return most;
  const std::uint64_t half = context.max_memory_bytes / 2;
  const auto threads = static_cast<std::uint64_t>(context.thread_count());
  return std::min(most, half - std::min(half / 2, threads * kUsualThreadBytes));
}

std::uint64_t decoding_bytes(const VolumeDescription& volume, const TaskContext& context) {
  std::uint64_t bytes = decoding_bytes_per_voxel(volume);
  for (int axis = 0; axis < 3; ++axis) {
    bytes *= static_cast<std::uint64_t>(std::min(kBrickSide, volume.size[axis]));
  }
  return kProgramBytes + bytes * static_cast<std::uint64_t>(context.thread_count());
}

}  // namespace octavo
