// Bricks of voxels on their way through a codec.
#pragma once

#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"

namespace octavo::testing {

/// The first brick of tier 0 of a volume; all of it where no side exceeds 64.
inline BrickShape shape_of(const Size3& size, const Point3& spacing = {1, 1, 1}) {
  const Levels levels(size, choose_halvings(size, spacing));
  return brick_shape(levels, 0, {0, 0, 0});
}

/// Dense voxels [z][y][x].
template <class T>
BrickView view_of(const std::vector<T>& voxels, const Size3& size) {
  return {voxels.data(), voxel_type_of<T>(), size, size.x, size.x * size.y};
}

inline std::vector<ByteSpan> spans_of(const EncodedBrick& brick) {
  return {brick.segments.begin(), brick.segments.end()};
}

/// The parent that the coarsest segment of a brick alone tells; of a stored brick segment 0.
inline std::int64_t decoded_parent(const BrickCodec& codec, const BrickShape& shape,
                                   VoxelType type, const EncodedBrick& brick) {
  std::vector<ByteSpan> segments = spans_of(brick);
  const std::size_t kept = segments.back().empty() ? 0 : segments.size() - 1;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    if (i != kept) segments[i] = {};
  }
  return codec.decode_parent(shape, type, brick.range, segments);
}

}  // namespace octavo::testing
