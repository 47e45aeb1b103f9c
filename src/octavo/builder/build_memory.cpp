#include "octavo/builder/build_memory.h"

#include <algorithm>

#include "octavo/builder/build_setup.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/training.h"
#include "octavo/core/checked.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
constexpr std::uint64_t kBytesPerBrick = 192;
// Training and the file's own buffers.
constexpr std::uint64_t kFixedBytes = 192 * kMiB;

// What a build takes besides the voxels of groups.
std::uint64_t base_bytes(int threads) {
  return static_cast<std::uint64_t>(build_threads(threads)) * kThreadBytes + kFixedBytes;
}

// Below this a band is hardly worth reading its planes; where voxels change it is a row of bricks.
std::uint64_t fewest_band_bytes(const VolumeDescription& volume, const BuildOptions& options) {
  constexpr std::uint64_t kFewestBytes = 16 * kMiB;
  if (options.max_error == 0 && options.keep_details == 0) return kFewestBytes;
  const Size3 side = levels_of(volume).brick_side(0);
  const std::int64_t width = is_integer(volume.type) ? bytes_per_voxel(volume.type) : 8;
  const auto row = static_cast<std::uint64_t>(volume.size.x * side.y * side.z * width);
  return std::max(kFewestBytes, row);
}

}  // namespace

std::uint64_t build_memory_bytes(const VolumeDescription& description, int threads,
                                 double max_error) {
  const Levels levels = levels_of(description);
  const auto planes = static_cast<std::uint64_t>(group_planes(levels, description.type));
  // float32: the planes read for the coding; with a max error the voxels beside their codes.
  const std::uint64_t count = is_integer(description.type) ? 2 : max_error > 0 ? 5 : 3;
  const std::uint64_t groups =
      checked_mul(count * planes, plane_bytes(description), "the memory of groups");
  return checked_add(groups, base_bytes(threads), "the memory of a build");
}

std::uint64_t join_memory_bytes(const VolumeDescription& description, int threads) {
  const auto bricks =
      static_cast<std::uint64_t>(levels_of(description).brick_grid(0).voxel_count());
  return checked_add(checked_mul(bricks, kBytesPerBrick, "the memory of a join"),
                     base_bytes(threads), "the memory of a join");
}

std::uint64_t band_memory_bytes(const VolumeDescription& description, int threads,
                                std::uint64_t band_bytes) {
  const Size3 grid = levels_of(description).brick_grid(0);
  // Of each brick, and once more of those of a layer that wait in a sorter.
  const auto bricks =
      static_cast<std::uint64_t>(grid.voxel_count() + grid.x * grid.y) * kBytesPerBrick;
  // A plane as it is read, of float32 once more as it is given.
  const std::uint64_t planes = is_integer(description.type) ? 1 : 2;
  const std::uint64_t bands = checked_add(planes * plane_bytes(description) + bricks,
                                          2 * band_bytes, "the memory of bands");
  return checked_add(bands, base_bytes(threads), "the memory of bands");
}

std::uint64_t share_memory_bytes(const VolumeDescription& description, int threads,
                                 std::uint64_t share_bytes) {
  const Size3 side = levels_of(description).brick_side(0);
  const auto training = static_cast<std::uint64_t>(
      static_cast<std::int64_t>(kTrainingBricks) * side.voxel_count() *
      bytes_per_voxel(description.type));
  return checked_add(band_memory_bytes(description, threads, 0) + training, share_bytes,
                     "the memory of a share");
}

std::uint64_t share_band_bytes(const PlaneSource& source, const BuildOptions& options,
                               int threads, std::uint64_t share_bytes) {
  const VolumeDescription& volume = source.description();
  if (!source.can_seek()) {
    throw Error(ErrorKind::invalid_argument,
                "the source can only be read from its start on: parts cannot share a group of it");
  }
  if (options.band_bytes > 0) return options.band_bytes;
  const std::uint64_t limit = options.max_memory_bytes;
  const std::uint64_t base = checked_add(share_memory_bytes(volume, threads, 0),
                                         source.resident_bytes(), "the memory of a share");
  if (limit == 0 || checked_add(base, share_bytes, "the memory of a share") <= limit) {
    return share_bytes;
  }
  const std::uint64_t fewest = 2 * fewest_band_bytes(volume, options);
  check_build_memory(base + std::min(share_bytes, fewest), limit, build_threads(threads));
  return (limit - base) / 2;
}

std::uint64_t band_bytes_of(const PlaneSource& source, const BuildOptions& options, int threads) {
  const VolumeDescription& volume = source.description();
  const std::uint64_t held = source.resident_bytes();
  const std::uint64_t whole =
      checked_add(build_memory_bytes(volume, threads, options.max_error), held, "the memory");
  const bool fits = options.max_memory_bytes == 0 || whole <= options.max_memory_bytes;
  if (options.band_bytes == 0 && fits) return 0;
  if (!source.can_seek()) {
    if (options.band_bytes > 0) throw Error(ErrorKind::invalid_argument, "bands cannot be read");
    check_build_memory(whole, options.max_memory_bytes, build_threads(threads),
                       "; bands of bricks need less, but this source can only be read from its "
                       "start on");
  }
  if (options.band_bytes > 0) return options.band_bytes;
  const std::uint64_t fewest = fewest_band_bytes(volume, options);
  const std::uint64_t base =
      checked_add(band_memory_bytes(volume, threads, 0), held, "the memory of bands");
  check_build_memory(base + 2 * fewest, options.max_memory_bytes, build_threads(threads));
  return (options.max_memory_bytes - base) / 2;
}

}  // namespace octavo
