// What Highway's tables of functions call of its library: which instruction sets there are, and
// which one was chosen. The library itself measures a timer whenever it is loaded, for benchmarks,
// which takes as long as all else at the start of the program.
#include "octavo/codec/simd_targets.h"

#include <hwy/highway.h>

namespace hwy {

namespace {

/// Those whose instructions the processor has, and whose registers the system saves: of each all
/// that Highway lets the compiler use for it.
std::int64_t found_targets() {
  std::int64_t targets = HWY_ENABLED_BASELINE | HWY_EMU128 | HWY_SCALAR;
#if HWY_ARCH_X86 && (HWY_TARGETS & (HWY_TARGETS - 1)) != 0
  const auto has = [](auto... found) { return ((found != 0) && ...); };
  if (!has(__builtin_cpu_supports("sse4.2"), __builtin_cpu_supports("pclmul"),
           __builtin_cpu_supports("aes"))) {
    return targets;
  }
  targets |= HWY_SSE4;
  if (!has(__builtin_cpu_supports("avx2"), __builtin_cpu_supports("fma"),
           __builtin_cpu_supports("bmi"), __builtin_cpu_supports("bmi2"),
           __builtin_cpu_supports("lzcnt"), __builtin_cpu_supports("f16c"))) {
    return targets;
  }
  targets |= HWY_AVX2;
  if (!has(__builtin_cpu_supports("avx512f"), __builtin_cpu_supports("avx512vl"),
           __builtin_cpu_supports("avx512dq"), __builtin_cpu_supports("avx512bw"),
           __builtin_cpu_supports("avx512cd"))) {
    return targets;
  }
  targets |= HWY_AVX3;
  if (!has(__builtin_cpu_supports("avx512vnni"), __builtin_cpu_supports("avx512vbmi"),
           __builtin_cpu_supports("avx512vbmi2"), __builtin_cpu_supports("vpclmulqdq"),
           __builtin_cpu_supports("vaes"), __builtin_cpu_supports("avx512vpopcntdq"),
           __builtin_cpu_supports("avx512bitalg"))) {
    return targets;
  }
  targets |= HWY_AVX3_DL;
#endif
  return targets;
}

}  // namespace

decltype(SupportedTargets()) SupportedTargets() {
  static const std::int64_t targets = found_targets();
  return targets;
}

ChosenTarget& GetChosenTarget() {
  static ChosenTarget target;
  return target;
}

}  // namespace hwy
