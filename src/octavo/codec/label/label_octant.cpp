#include "octavo/codec/label/label_octant.h"

#include "octavo/core/error.h"

namespace octavo {

namespace {

bool is_label_shape(const BrickShape& shape) {
  if (shape.level_count < 1 || shape.level_count > kTierLevels) return false;
  for (int axis = 0; axis < 3; ++axis) {
    if (shape.size[0][axis] < 1 || shape.size[0][axis] > 64) return false;
  }
  Size3 expected = shape.size[0];
  for (int i = 0; i < shape.level_count; ++i) {
    const auto level = static_cast<std::size_t>(i);
    if (shape.halving[level] > kHalveAll || !(shape.size[level] == expected)) return false;
    expected = halved(expected, shape.halving[level]);
  }
  return expected == Size3{1, 1, 1};
}

}  // namespace

void check_label_shape(const BrickShape& shape) {
  if (is_label_shape(shape)) return;
  throw Error(ErrorKind::invalid_argument,
              "the levels of this brick do not lead to a single sample");
}

void check_label_type(VoxelType type) {
  if (is_integer(type)) return;
  throw Error(ErrorKind::invalid_argument, "labels must be integers, found float32 voxels");
}

}  // namespace octavo
