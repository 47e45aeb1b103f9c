#include "octavo/ops/mask/file_mask.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstddef>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"

namespace octavo {

namespace {

constexpr const char* kAdvice = "raise the limit, or take a coarser level";

enum class Verdict { none, all, some };

// Whether the values lowest .. highest are in the windows.
Verdict judge(double lowest, double highest, std::span<const ValueWindow> windows) {
  Verdict verdict = Verdict::none;
  for (const ValueWindow& window : windows) {
    if (window.contains(lowest) && window.contains(highest)) return Verdict::all;
    if (window.lowest <= highest && window.highest >= lowest) verdict = Verdict::some;
  }
  return verdict;
}

// Takes the bricks of a file, or boxes of a coarser level, into a mask.
class FileMask {
 public:
  FileMask(const FileReader& reader, int level, std::span<const ValueWindow> windows,
           Progress& progress, std::uint64_t max_bytes)
      : reader_(reader),
        level_(level),
        windows_(windows),
        progress_(progress),
        max_bytes_(max_bytes),
        size_(reader.levels().size(level)),
        builder_(size_) {}

  MaskTree make() {
    // Coarser levels are read in boxes of a cube; bricks of level 0 lie on the grid of words.
    const Size3 side = level_ == 0 ? reader_.levels().brick_side(0) : Size3{64, 64, 64};
    for (std::int64_t z = 0; z < size_.z; z += MaskBuilder::kLayerPlanes) {
      const std::int64_t end = std::min(size_.z, z + MaskBuilder::kLayerPlanes);
      const Size3 grid{(size_.x + side.x - 1) / side.x, (size_.y + side.y - 1) / side.y,
                       (end - z + side.z - 1) / side.z};
      tbb::parallel_for(std::int64_t{0}, grid.voxel_count(), [&](std::int64_t i) {
        const Index3 lo{i % grid.x * side.x, i / grid.x % grid.y * side.y,
                        z + i / (grid.x * grid.y) * side.z};
        const Box box = intersection(
            box_of(size_), {lo, {lo.x + side.x, lo.y + side.y, lo.z + side.z}});
        if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
        level_ == 0 ? take_brick(box, side) : take_box(box);
      });
      builder_.finish_layer();
      require_memory_within(builder_.memory_bytes(), max_bytes_, "the mask", kAdvice);
      progress_.advance(end - z);
    }
    return builder_.finish();
  }

 private:
  void take_brick(const Box& box, const Size3& side) {
    const BrickEntry entry = reader_.brick(
        0, {box.lo.x / side.x, box.lo.y / side.y, box.lo.z / side.z});
    const VolumeDescription& description = reader_.description();
    const auto [least, greatest] = std::minmax(
        {description.voxel_of(entry.range.min), description.voxel_of(entry.range.max)});
    switch (judge(least, greatest, windows_)) {
      case Verdict::none: return;
      case Verdict::all: builder_.fill_block(box); return;
      case Verdict::some: break;
    }
    add(box, [&](std::byte* voxels) { reader_.read_brick(entry, 0, voxels); });
  }

  void take_box(const Box& box) {
    add(box, [&](std::byte* voxels) { reader_.read(box, level_, voxels); });
  }

  template <class Read>
  void add(const Box& box, Read read) {
    const VoxelType type = reader_.description().type;
    const Size3 size = box.size();
    std::vector<std::byte> voxels(
        static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(type)));
    read(voxels.data());
    const BrickView block{voxels.data(), type, size, size.x, size.x * size.y};
    for (const ValueWindow& window : windows_) builder_.add_block(box.lo, block, window);
  }

  const FileReader& reader_;
  int level_;
  std::span<const ValueWindow> windows_;
  Progress& progress_;
  std::uint64_t max_bytes_;
  Size3 size_;
  MaskBuilder builder_;
};

}  // namespace

MaskTree mask_of_file(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                      Progress& progress, std::uint64_t max_bytes) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  return FileMask(reader, level, windows, progress, max_bytes).make();
}

}  // namespace octavo
