// Label maps as arrays: what label trees are held against.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "octavo/ops/label/label_build.h"
#include "octavo/planes/memory_source.h"
#include "support/built_file.h"
#include "support/dense_mask.h"

namespace octavo::testing {

struct DenseLabels {
  explicit DenseLabels(const Size3& s, std::int32_t label = 0)
      : size(s), voxels(static_cast<std::size_t>(s.voxel_count()), label) {}

  Size3 size;
  std::vector<std::int32_t> voxels;  ///< [z][y][x]

  std::int32_t& at(const Index3& p) {
    return voxels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }
  std::int32_t at(const Index3& p) const { return const_cast<DenseLabels*>(this)->at(p); }
  bool operator==(const DenseLabels&) const = default;

  /// Clipped to the volume.
  void fill(const Box& wanted, std::int32_t label) {
    const Box box = intersection(wanted, box_of(size));
    for_each_voxel(box.size(), [&](const Index3& p) {
      at({box.lo.x + p.x, box.lo.y + p.y, box.lo.z + p.z}) = label;
    });
  }
};

/// Boxes and grains of these labels and of 0.
inline DenseLabels random_labels(const Size3& size, std::span<const std::int32_t> names,
                                 std::mt19937& random) {
  DenseLabels labels(size);
  const auto below = [&](std::int64_t n) {
    return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
  };
  for (std::size_t i = 0; i < names.size() + 4; ++i) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = below(size[axis]);
      box.hi[axis] = box.lo[axis] + 1 + below(size[axis] - box.lo[axis]);
      if (i > 4) box.hi[axis] = std::min(box.hi[axis], box.lo[axis] + 9);
    }
    labels.fill(box, random() % 4 == 0 ? 0 : names[random() % names.size()]);
  }
  for (std::int64_t grains = below(60); grains > 0; --grains) {
    labels.at({below(size.x), below(size.y), below(size.z)}) = names[random() % names.size()];
  }
  return labels;
}

inline LabelTree tree_of(const DenseLabels& labels) {
  const Size3& size = labels.size;
  return make_labels({labels.voxels.data(), VoxelType::int32, size, size.x, size.x * size.y});
}

inline DenseLabels dense_of(const LabelTree& tree) {
  DenseLabels labels(tree.size());
  for_each_voxel(labels.size, [&](const Index3& p) {
    labels.at(p) = static_cast<std::int32_t>(tree.label_at(p));
  });
  return labels;
}

/// As a label map to build a file of.
inline Volume volume_of(const DenseLabels& labels, double spacing_z_mm) {
  Volume volume;
  volume.description.kind = VolumeKind::labels;
  volume.description.type = VoxelType::int32;
  volume.description.size = labels.size;
  volume.description.geometry.spacing_mm = {1, 1, spacing_z_mm};
  volume.voxels.resize(labels.voxels.size() * sizeof labels.voxels[0]);
  std::memcpy(volume.voxels.data(), labels.voxels.data(), volume.voxels.size());
  return volume;
}

}  // namespace octavo::testing
