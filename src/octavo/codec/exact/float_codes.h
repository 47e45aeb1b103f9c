// The codes of the float voxels of a brick.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_bins.h"

namespace octavo::exact {

/// The voxels of a brick, dense [z][y][x], and what is told of them.
struct QuantizedBrick {
  std::vector<float> voxels;
  std::vector<std::int32_t> codes;  ///< of absent voxels those of fill_absent
  AbsentFlags absent;               ///< empty: none is
  float min = 0;                    ///< of the finite ones
  float max = 0;
  bool has_places = false;          ///< a finite voxel of level 0 is not that of its code
};

/// Requires a view of float32 voxels.
QuantizedBrick quantized(const SampleCoding& coding, const BrickShape& shape,
                         const BrickView& view);

/// The codes as voxels of type int32. The brick must outlive the view.
BrickView code_view(const QuantizedBrick& brick, const Size3& size);

}  // namespace octavo::exact
