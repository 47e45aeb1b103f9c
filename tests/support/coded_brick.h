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

}  // namespace octavo::testing
