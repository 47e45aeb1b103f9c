#include "octavo/builder/tree_bricks.h"

#include <algorithm>
#include <cstddef>
#include <span>
#include <type_traits>

#include "octavo/builder/sha256_lanes.h"
#include "octavo/core/bytes.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/octree/tree_child.h"
#include "octavo/octree/tree_words.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kStripBytes = std::int64_t{1} << 17;
constexpr std::int64_t kSlabPlanes = 4;  // words are as thick

std::int64_t divided_up(std::int64_t a, std::int64_t b) { return (a + b - 1) / b; }

// Checksums of pieces that follow each other, joined.
class JoinedChecksum {
 public:
  void add(std::uint32_t crc, std::uint64_t byte_count) {
    if (byte_count != byte_count_) shift_ = crc32c_shift(byte_count);
    byte_count_ = byte_count;
    crc_ = crc32c_joined(crc_, crc, shift_);
  }
  std::uint32_t value() const { return crc_; }

 private:
  std::uint32_t crc_ = 0;
  std::uint64_t byte_count_ = 0;
  std::uint32_t shift_ = crc32c_shift(0);
};

// The bytes of one of `planes` planes of voxels.
template <class T>
ByteSpan bytes_of_plane(const std::vector<T>& voxels, std::int64_t plane, std::int64_t planes) {
  const std::size_t run = voxels.size() * sizeof(T) / static_cast<std::size_t>(planes);
  const auto* first = reinterpret_cast<const std::uint8_t*>(voxels.data());
  return {first + static_cast<std::size_t>(plane) * run, run};
}

// Calls f(T()) with the C++ type of labels.
template <class F>
auto with_label_type(VoxelType type, F f) {
  return with_voxel_type(type, [&](auto id) -> decltype(f(std::uint8_t())) {
    using T = typename decltype(id)::type;
    if constexpr (std::is_integral_v<T>) {
      return f(T());
    } else {
      throw Error(ErrorKind::invalid_argument, "float32 voxels are no labels");
    }
  });
}

template <class Tree>
class BricksOf final : public TreeBricks {
 public:
  BricksOf(const Tree& tree, const Levels& levels)
      : tree_(tree), levels_(levels), side_(levels.brick_side(0)), grid_(levels.brick_grid(0)) {}

  bool fits(VoxelType type) const override {
    const ValueRange range = value_range(type);
    const auto labels = labels_of(tree_);
    return labels.front() >= range.min && labels.back() <= range.max;
  }

  std::vector<std::int64_t> labels_of_layer(std::int64_t layer) const override {
    std::vector<std::int64_t> labels(static_cast<std::size_t>(grid_.x * grid_.y));
    const Box whole = box_of(tree_.size());
    Box planes = whole;
    planes.lo.z = layer * side_.z;
    planes.hi.z = std::min(whole.hi.z, planes.lo.z + side_.z);
    const auto uniform = [&](const Box& part, std::uint32_t label) {
      const std::int64_t value = labels_of(tree_)[label];
      for (std::int64_t y = part.lo.y / side_.y; y < divided_up(part.hi.y, side_.y); ++y) {
        const auto row = labels.begin() + y * grid_.x;
        std::fill(row + part.lo.x / side_.x, row + divided_up(part.hi.x, side_.x), value);
      }
    };
    const auto stored = [&](std::uint64_t, const Index3& corner) {
      const Box cell{corner, {corner.x + kCellSide, corner.y + kCellSide, corner.z + kCellSide}};
      visit_cells(intersection(cell, planes), side_, [&](const Index3& brick) {
        labels[static_cast<std::size_t>(brick.y * grid_.x + brick.x)] =
            only_label(tree_, levels_.brick_box(0, brick)).value_or(kSeveralLabels);
        return true;
      });
    };
    visit_tree_cells(tree_, planes, uniform, stored);
    return labels;
  }

  void words_of_brick(const Index3& brick, LabelWords& words) const override {
    words_of(tree_, levels_.brick_box(0, brick), words);
  }

  std::vector<Sha256Digest> plane_digests(std::int64_t layer, std::int64_t planes, VoxelType type,
                                          const Progress& watcher) const override {
    return with_label_type(type,
                           [&]<class T>(T) { return digests_as<T>(layer, planes, watcher); });
  }

  std::uint32_t checksum(std::int64_t planes, VoxelType type) const override {
    return with_label_type(type, [&]<class T>(T) { return checksum_as<T>(planes); });
  }

 private:
  // Four planes at a time, which share their words, strip of rows by strip of rows.
  template <class T>
  std::vector<Sha256Digest> digests_as(std::int64_t layer, std::int64_t count,
                                       const Progress& watcher) const {
    const Size3& size = tree_.size();
    const std::int64_t first = layer * side_.z;
    const std::int64_t end = first + count;
    const std::int64_t rows = strip_rows<T>();
    std::vector<Sha256Digest> digests(static_cast<std::size_t>(end - first));
    const auto hash_slab = [&](std::int64_t slab) {
      const std::int64_t z = first + slab * kSlabPlanes;
      const std::int64_t planes = std::min(kSlabPlanes, end - z);
      Sha256Lanes lanes(static_cast<std::size_t>(planes), zero_states_);
      const std::int64_t zero_rows = rows_of_zeros(z, planes);
      lanes.add_zeros(static_cast<std::uint64_t>(zero_rows * size.x) * sizeof(T));
      std::vector<T> voxels;
      for (std::int64_t y = zero_rows; y < size.y; y += rows) {
        if (watcher.is_cancelled()) return;
        const Box box{{0, y, z}, {size.x, std::min(size.y, y + rows), z + planes}};
        const auto voxel_count = static_cast<std::size_t>(box.size().voxel_count());
        voxels.resize(voxel_count);
        fill_voxels(tree_, box, voxels.data());
        lanes.add({reinterpret_cast<const std::uint8_t*>(voxels.data()), voxel_count * sizeof(T)});
      }
      const std::vector<Sha256Digest> found = lanes.digests();
      std::copy(found.begin(), found.end(), digests.begin() + slab * kSlabPlanes);
    };
    run_isolated([&] {
      parallel_for(std::int64_t{0}, divided_up(end - first, kSlabPlanes), hash_slab);
    });
    if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while hashing planes");
    return digests;
  }

  // So many of the first rows of planes have only zeros, as far as whole cells tell.
  std::int64_t rows_of_zeros(std::int64_t z, std::int64_t planes) const {
    std::int64_t rows = tree_.size().y;
    const Box slab{{0, 0, z}, {tree_.size().x, rows, z + planes}};
    const auto uniform = [&](const Box& part, std::uint32_t label) {
      if (labels_of(tree_)[label] != 0) rows = std::min(rows, part.lo.y);
    };
    const auto stored = [&](std::uint64_t, const Index3& corner) {
      rows = std::min(rows, corner.y);
    };
    visit_tree_cells(tree_, slab, uniform, stored);
    return rows;
  }

  // Rows of a strip of four planes, a multiple of the side of a word.
  template <class T>
  std::int64_t strip_rows() const {
    const Size3& size = tree_.size();
    const std::int64_t row_bytes = static_cast<std::int64_t>(sizeof(T)) * size.x;
    return std::clamp<std::int64_t>(kStripBytes / (kSlabPlanes * row_bytes) / 4 * 4, 4, size.y + 3);
  }

  // Slabs of four planes are cut into strips of rows; a strip has a run of bytes in each plane.
  template <class T>
  std::uint32_t checksum_as(std::int64_t planes) const {
    const Size3& size = tree_.size();
    const auto row_bytes = static_cast<std::int64_t>(sizeof(T)) * size.x;
    const std::int64_t rows = strip_rows<T>();
    const std::int64_t strips = divided_up(size.y, rows);
    const std::int64_t slabs = divided_up(planes, kSlabPlanes);
    std::vector<std::uint32_t> crcs(static_cast<std::size_t>(planes * strips));
    parallel_for(std::int64_t{0}, slabs * strips, [&](std::int64_t i) {
      const std::int64_t y = i % strips * rows;
      const std::int64_t z = i / strips * kSlabPlanes;
      const Box box{{0, y, z}, {size.x, std::min(size.y, y + rows), std::min(planes, z + 4)}};
      std::vector<T> voxels(static_cast<std::size_t>(box.size().voxel_count()));
      fill_voxels(tree_, box, voxels.data());
      for (std::int64_t plane = z; plane < box.hi.z; ++plane) {
        crcs[static_cast<std::size_t>(plane * strips + i % strips)] =
            crc32c(bytes_of_plane(voxels, plane - z, box.size().z));
      }
    });
    JoinedChecksum joined;
    for (std::int64_t i = 0; i < planes * strips; ++i) {
      const std::int64_t y = i % strips * rows;
      joined.add(crcs[static_cast<std::size_t>(i)],
                 static_cast<std::uint64_t>(std::min(rows, size.y - y) * row_bytes));
    }
    return joined.value();
  }

  const Tree& tree_;
  const Levels& levels_;
  Size3 side_;
  Size3 grid_;
  mutable ZeroStates zero_states_;
};

}  // namespace

std::unique_ptr<TreeBricks> bricks_of_tree(const MaskTree& tree, const Levels& levels) {
  return std::make_unique<BricksOf<MaskTree>>(tree, levels);
}

std::unique_ptr<TreeBricks> bricks_of_tree(const LabelTree& tree, const Levels& levels) {
  return std::make_unique<BricksOf<LabelTree>>(tree, levels);
}

}  // namespace octavo
