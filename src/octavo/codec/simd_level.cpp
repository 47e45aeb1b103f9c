#include "octavo/codec/simd_level.h"

#include <cstdlib>
#include <utility>

#include "octavo/codec/simd_targets.h"

#include <hwy/highway.h>

namespace octavo {

namespace {

std::mutex& dispatch_mutex() {
  static std::mutex mutex;
  return mutex;
}

}  // namespace

std::int64_t simd_targets_of(std::string_view level) {
  constexpr std::pair<std::string_view, std::int64_t> kNames[] = {
      {"sse4", HWY_SSE4},      {"avx2", HWY_AVX2}, {"avx512", HWY_AVX3},
      {"avx512", HWY_AVX3_DL}, {"neon", HWY_NEON}, {"wasm", HWY_WASM}};
  std::int64_t targets = 0;
  for (const auto& [name, target] : kNames) {
    if (name == level) targets |= target;
  }
  return targets & HWY_TARGETS & hwy::SupportedTargets();
}

std::int64_t chosen_simd_targets() {
  const char* const asked = std::getenv("OCTAVO_SIMD");
  const std::string_view level = asked == nullptr ? "" : asked;
  if (level == "scalar") return 0;
  const std::int64_t targets = simd_targets_of(level);
  return targets != 0 ? targets : std::int64_t{hwy::SupportedTargets()};
}

SimdTargetsInUse::SimdTargetsInUse(std::int64_t targets) : lock_(dispatch_mutex()) {
  hwy::GetChosenTarget().Update(targets);
}

SimdTargetsInUse::~SimdTargetsInUse() { hwy::GetChosenTarget().Update(hwy::SupportedTargets()); }

}  // namespace octavo
