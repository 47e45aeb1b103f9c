// The bricks of tier 0 of a volume whose voxels stand in a tree.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/progress.h"
#include "octavo/core/voxel_type.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/label_words.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Stands for the label of a brick that has several.
inline constexpr std::int64_t kSeveralLabels = std::numeric_limits<std::int64_t>::min();

/// What a builder asks of a tree of any kind. Immutable; serves any number of threads.
class TreeBricks {
 public:
  virtual ~TreeBricks() = default;

  /// Whether every label is one of the type's values.
  virtual bool fits(VoxelType type) const = 0;

  /// The label of each brick of a layer, [y][x]. Sub-trees of one label cost a step, whatever
  /// their size, besides the entries of their bricks.
  virtual std::vector<std::int64_t> labels_of_layer(std::int64_t layer) const = 0;

  /// The words of a brick.
  virtual void words_of_brick(const Index3& brick, LabelWords& words) const = 0;

  /// The digests of the first planes of a layer, by z, of voxels of the type. Uses the threads of
  /// the calling task arena.
  /// planes  how many of them; at most those of the layer
  /// Throws  Error{cancelled}
  /// Memory  about 1 MiB per thread, or four rows
  virtual std::vector<Sha256Digest> plane_digests(std::int64_t layer, std::int64_t planes,
                                                  VoxelType type,
                                                  const Progress& watcher) const = 0;

  /// CRC-32C of the voxels of the first planes, [z][y][x] of the type. Uses the threads of the
  /// calling task arena.
  /// Memory  about 1 MiB per thread, or four rows
  virtual std::uint32_t checksum(std::int64_t planes, VoxelType type) const = 0;
};

/// The tree and the levels must outlive the result.
std::unique_ptr<TreeBricks> bricks_of_tree(const MaskTree& tree, const Levels& levels);
std::unique_ptr<TreeBricks> bricks_of_tree(const LabelTree& tree, const Levels& levels);

}  // namespace octavo
