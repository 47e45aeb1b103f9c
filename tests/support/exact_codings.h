// Codings of exact floats: fine, coarse and shifted ones.
#pragma once

#include "octavo/core/sample_coding.h"

namespace octavo::testing {

inline SampleCoding exact_coding(double scale, double offset = 0) {
  return {VoxelType::int32, scale, offset, true};
}

inline const SampleCoding kExactCodings[] = {
    exact_coding(0.25), exact_coding(0x1p-148), exact_coding(0.1), exact_coding(1e30),
    exact_coding(0.37, 1000.25), exact_coding(1, 0.5), exact_coding(3e38), exact_coding(0x1p-30),
    exact_coding(1e-3, -1e6), exact_coding(0.1, 7), exact_coding(0x1p127)};

}  // namespace octavo::testing
