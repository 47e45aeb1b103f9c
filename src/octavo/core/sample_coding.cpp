#include "octavo/core/sample_coding.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace octavo {

namespace {

constexpr double kLargestFloat = std::numeric_limits<float>::max();

float voxel_at(double code, double scale, double offset) {
  const double value = std::clamp(code * scale + offset, -kLargestFloat, kLargestFloat);
  return static_cast<float>(value) + 0.0f;  // -0 becomes 0
}

}  // namespace

float SampleCoding::voxel_of(std::int64_t code) const {
  if (is_exact && code >= kUnbounded) return kLargestFloat;
  if (is_exact && code <= -kUnbounded) return -kLargestFloat;
  return voxel_at(static_cast<double>(code), scale, offset);
}

bool is_valid(const SampleCoding& coding) noexcept {
  return is_valid(coding.type) && is_integer(coding.type) && std::isfinite(coding.scale) &&
         coding.scale > 0 && std::isfinite(coding.offset) &&
         (!coding.is_exact || coding.type == VoxelType::int32);
}

void decode_samples(const SampleCoding& coding, const void* codes, std::span<float> voxels) {
  const auto* const from = static_cast<const std::byte*>(codes);
  auto* const to = reinterpret_cast<std::byte*>(voxels.data());
  with_voxel_type(coding.type, [&](auto tag) {
    using Code = typename decltype(tag)::type;
    // From the back: a code is never wider than a float, so that none is overwritten unread.
    for (std::size_t i = voxels.size(); i-- > 0;) {
      Code code;
      std::memcpy(&code, from + i * sizeof code, sizeof code);
      const float voxel = voxel_at(static_cast<double>(code), coding.scale, coding.offset);
      std::memcpy(to + i * sizeof voxel, &voxel, sizeof voxel);
    }
  });
}

}  // namespace octavo
