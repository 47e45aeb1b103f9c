// Whether floats take fewer bytes bit by bit than within a maximum error, as few different values
// may: rounding hides how few they are.
#pragma once

#include <cstdint>

#include "octavo/builder/float_stack.h"
#include "octavo/core/box.h"
#include "octavo/core/sample_coding.h"

namespace octavo {

/// Planes of `x` by `y` voxels.
struct TrialStack {
  const FloatStack& planes;
  std::int64_t x = 0;
  std::int64_t y = 0;
};

/// Whether `one` takes fewer bytes than `other`: codes some boxes of the planes bit by bit with
/// both, by the fast preset.
bool is_smaller_coding(const TrialStack& stack, const SampleCoding& one, const SampleCoding& other);

/// Whether bit by bit takes fewer bytes than within a maximum error: codes some boxes of the planes
/// in both ways, by the fast preset.
/// exact        for floats bit by bit
/// within       for floats within a maximum error; all have such codes
/// codec_error  by how much a codec may change these codes
/// Time         that of training two models on up to 2^18 voxels
bool is_smaller_exact(const TrialStack& stack, const SampleCoding& exact,
                      const SampleCoding& within, std::int64_t codec_error);

}  // namespace octavo
