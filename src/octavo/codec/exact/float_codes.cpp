#include "octavo/codec/exact/float_codes.h"

#include <algorithm>
#include <cmath>

namespace octavo::exact {

namespace {

std::vector<float> dense_voxels(const BrickView& view) {
  std::vector<float> voxels;
  voxels.reserve(static_cast<std::size_t>(view.size.voxel_count()));
  const auto* const from = static_cast<const float*>(view.voxels);
  for (std::int64_t z = 0; z < view.size.z; ++z) {
    for (std::int64_t y = 0; y < view.size.y; ++y) {
      const float* const row = from + z * view.plane_stride + y * view.row_stride;
      voxels.insert(voxels.end(), row, row + view.size.x);
    }
  }
  return voxels;
}

}  // namespace

QuantizedBrick quantized(const SampleCoding& coding, const BrickShape& shape,
                         const BrickView& view) {
  const FloatBins bins(coding);
  QuantizedBrick brick;
  brick.voxels = dense_voxels(view);
  brick.codes.resize(brick.voxels.size());
  bool has_finite = false;
  bool is_of_codes = true;
  for (std::size_t i = 0; i < brick.voxels.size(); ++i) {
    const float voxel = brick.voxels[i];
    if (!std::isfinite(voxel)) {
      if (brick.absent.empty()) brick.absent.resize(brick.voxels.size());
      brick.absent[i] = 1;
      continue;
    }
    const std::int64_t code = bins.code_of(voxel);
    brick.codes[i] = static_cast<std::int32_t>(code);
    brick.min = has_finite ? std::min(brick.min, voxel) : voxel;
    brick.max = has_finite ? std::max(brick.max, voxel) : voxel;
    has_finite = true;
    is_of_codes = is_of_codes && bits_of(coding.voxel_of(code)) == bits_of(voxel);
  }
  brick.has_places = !is_of_codes && shape.first_level == 0;
  if (!brick.absent.empty()) fill_absent(shape, brick.absent, brick.codes);
  return brick;
}

BrickView code_view(const QuantizedBrick& brick, const Size3& size) {
  return {brick.codes.data(), VoxelType::int32, size, size.x, size.x * size.y};
}

}  // namespace octavo::exact
