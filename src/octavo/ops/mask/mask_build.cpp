#include "octavo/ops/mask/mask_build.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/ops/mask/mask_kernels.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::size_t kWordsPerCube = 4096;

// Where the 16 words along x lie in a cube, from the first.
constexpr std::array<std::size_t, 16> kAlongX = [] {
  std::array<std::size_t, 16> places{};
  for (std::size_t i = 0; i < 16; ++i) {
    for (std::size_t bit = 0; bit < 4; ++bit) places[i] |= (i >> bit & 1) << (3 * bit + 1);
  }
  return places;
}();

// The window as bounds of the type; false when no value of the type is in it.
template <class T>
bool bounds_in(const ValueWindow& window, VoxelType type, T& lowest, T& highest) {
  if (!(window.lowest <= window.highest)) return false;
  if constexpr (std::is_floating_point_v<T>) {
    // Rounded inwards, so that float comparisons decide as double ones do.
    constexpr T kInfinity = std::numeric_limits<T>::infinity();
    constexpr double kLargest = std::numeric_limits<T>::max();
    lowest = static_cast<T>(std::clamp(window.lowest, -kLargest, kLargest));
    highest = static_cast<T>(std::clamp(window.highest, -kLargest, kLargest));
    if (static_cast<double>(lowest) < window.lowest) lowest = std::nextafter(lowest, kInfinity);
    if (static_cast<double>(highest) > window.highest) {
      highest = std::nextafter(highest, -kInfinity);
    }
  } else {
    const ValueRange range = value_range(type);
    const double low = std::max(std::ceil(window.lowest), static_cast<double>(range.min));
    const double high = std::min(std::floor(window.highest), static_cast<double>(range.max));
    if (!(low <= high)) return false;
    lowest = static_cast<T>(low);
    highest = static_cast<T>(high);
  }
  return lowest <= highest;
}

// Calls take(y, z, words, their count) for the rows of words of a block that have voxels in the
// window; y and z are those of their first voxels.
template <class Take>
void visit_word_rows(const BrickView& block, const ValueWindow& window, Take take) {
  const Size3& size = block.size;
  with_voxel_type(block.type, [&](auto id) {
    using T = typename decltype(id)::type;
    T lowest;
    T highest;
    if (!bounds_in(window, block.type, lowest, highest)) return;
    RunRows rows(size.x);
    const auto count = static_cast<std::size_t>((size.x + 3) / 4);
    BrickView part = block;
    for (std::int64_t z = 0; z < size.z; z += 4) {
      for (std::int64_t y = 0; y < size.y; y += 4) {
        part.voxels =
            static_cast<const T*>(block.voxels) + z * block.plane_stride + y * block.row_stride;
        part.size = {size.x, std::min<std::int64_t>(4, size.y - y),
                     std::min<std::int64_t>(4, size.z - z)};
        rows.take(part, &lowest, &highest);
        take(y, z, rows, count);
      }
    }
  });
}

bool is_aligned(std::int64_t lo, std::int64_t hi, std::int64_t size) {
  return lo % 4 == 0 && (hi % 4 == 0 || hi == size);
}

}  // namespace

MaskBuilder::MaskBuilder(const Size3& size) : size_(size) {
  checked_voxel_count(size);
  for (int axis = 0; axis < 3; ++axis) cubes_[axis] = (size[axis] + kCubeSide - 1) / kCubeSide;
  words_.resize(static_cast<std::size_t>(cubes_.x * cubes_.y) * kWordsPerCube);
}

void MaskBuilder::require_block(const Box& box) const {
  const Box layer{{0, 0, layer_ * kLayerPlanes},
                  {size_.x, size_.y, std::min(size_.z, (layer_ + 1) * kLayerPlanes)}};
  bool is_placed = !box.is_empty() && layer.contains(box);
  for (int axis = 0; axis < 3; ++axis) {
    is_placed = is_placed && is_aligned(box.lo[axis], box.hi[axis], size_[axis]);
  }
  if (!is_placed) throw Error(ErrorKind::invalid_argument, "a block outside the layer or its grid");
}

std::uint64_t& MaskBuilder::word_at(const Index3& voxel) {
  const std::int64_t cube = voxel.y / kCubeSide * cubes_.x + voxel.x / kCubeSide;
  const std::uint64_t code = interleave({voxel.x >> 2 & 15, voxel.y >> 2 & 15, voxel.z >> 2 & 15});
  return words_[static_cast<std::size_t>(cube) * kWordsPerCube + code];
}

void MaskBuilder::add_block(const Index3& corner, const BrickView& block,
                            const ValueWindow& window) {
  const Size3& size = block.size;
  require_block({corner, {corner.x + size.x, corner.y + size.y, corner.z + size.z}});
  const auto before = static_cast<std::size_t>(corner.x / 4);
  visit_word_rows(block, window, [&](std::int64_t y, std::int64_t z, const RunRows& rows,
                                     std::size_t count) {
    std::uint64_t* const first = &word_at({0, corner.y + y, corner.z + z});
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = before + i;
      first[at / 16 * kWordsPerCube + kAlongX[at % 16]] |= rows.word(i);
    }
  });
}

void MaskBuilder::finish_layer() {
  if (layer_ == cubes_.z)
    throw Error(ErrorKind::invalid_argument, "more layers than the volume has");
  std::vector<MaskPart> parts(static_cast<std::size_t>(cubes_.x * cubes_.y));
  parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    const auto at = static_cast<std::int64_t>(i);
    std::uint64_t* const words = words_.data() + i * kWordsPerCube;
    if (std::all_of(words, words + kWordsPerCube, [](std::uint64_t word) { return word == 0; })) {
      return;
    }
    parts[i] = fold_cube(words, interleave({at % cubes_.x, at / cubes_.x, layer_}));
    std::memset(words, 0, kWordsPerCube * sizeof *words);
  });
  for (MaskPart& part : parts) {
    if (part.pieces.empty()) continue;
    part_bytes_ += octavo::memory_bytes(part);
    parts_.push_back(std::move(part));
  }
  ++layer_;
}

std::uint64_t MaskBuilder::memory_bytes() const {
  return words_.size() * sizeof(std::uint64_t) + 2 * part_bytes_;
}

MaskTree MaskBuilder::finish() {
  if (layer_ != cubes_.z)
    throw Error(ErrorKind::invalid_argument, "finished before the last layer");
  std::sort(parts_.begin(), parts_.end(), [](const MaskPart& a, const MaskPart& b) {
    return a.pieces.front().code < b.pieces.front().code;
  });
  MaskTree tree = assemble(size_, 1, parts_);
  parts_.clear();
  return tree;
}

void add_to_cube(const Index3& corner, const BrickView& block, const ValueWindow& window,
                 std::uint64_t* words) {
  const auto before = static_cast<std::size_t>(corner.x / 4);
  visit_word_rows(block, window, [&](std::int64_t y, std::int64_t z, const RunRows& rows,
                                     std::size_t count) {
    std::uint64_t* const first = words + interleave({0, (corner.y + y) / 4, (corner.z + z) / 4});
    for (std::size_t i = 0; i < count; ++i) first[kAlongX[before + i]] |= rows.word(i);
  });
}

MaskTree make_mask(const BrickView& volume, const ValueWindow& window) {
  MaskBuilder builder(volume.size);
  const std::int64_t voxel_bytes = bytes_per_voxel(volume.type);
  for (std::int64_t z = 0; z < volume.size.z; z += MaskBuilder::kLayerPlanes) {
    const std::int64_t planes = std::min(MaskBuilder::kLayerPlanes, volume.size.z - z);
    // Four planes, 64 rows of each: read one behind the other, words of few cubes.
    const std::int64_t slabs = (planes + 3) / 4;
    const std::int64_t strips = (volume.size.y + kCubeSide - 1) / kCubeSide;
    parallel_for(std::int64_t{0}, slabs * strips, [&](std::int64_t task) {
      const Index3 corner{0, task % strips * kCubeSide, z + 4 * (task / strips)};
      BrickView block = volume;
      block.size = {volume.size.x, std::min(kCubeSide, volume.size.y - corner.y),
                    std::min<std::int64_t>(4, volume.size.z - corner.z)};
      block.voxels = static_cast<const std::byte*>(volume.voxels) +
                     (corner.z * volume.plane_stride + corner.y * volume.row_stride) * voxel_bytes;
      builder.add_block(corner, block, window);
    });
    builder.finish_layer();
  }
  return builder.finish();
}

}  // namespace octavo
