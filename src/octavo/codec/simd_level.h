// Which instruction set encoders and decoders run on: the best one this machine has, or the one
// that the environment variable OCTAVO_SIMD names. The results are the same for all.
#pragma once

#include <cstdint>
#include <mutex>
#include <string_view>

namespace octavo {

/// The Highway targets of `level` (sse4, avx2, avx512, neon, wasm) that this machine has; 0
/// when it has none.
std::int64_t simd_targets_of(std::string_view level);

/// The Highway targets that OCTAVO_SIMD allows; 0 for "scalar", the portable functions. All that
/// this machine has when the variable is absent or names none of them.
std::int64_t chosen_simd_targets();

/// While it lives, Highway dispatches to the best of `targets`, which must not be 0; one at a time.
/// Functions are taken from Highway's tables while one lives, and called at any time.
class SimdTargetsInUse {
 public:
  explicit SimdTargetsInUse(std::int64_t targets);
  ~SimdTargetsInUse();
  SimdTargetsInUse(const SimdTargetsInUse&) = delete;
  SimdTargetsInUse& operator=(const SimdTargetsInUse&) = delete;

 private:
  std::lock_guard<std::mutex> lock_;
};

}  // namespace octavo
