// Runs of bytes, and the order of axes: words that codec, file and io share.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

using Bytes = std::vector<std::uint8_t>;
using ByteSpan = std::span<const std::uint8_t>;

/// The axes in the order in which a codec halves them; its splits go the other way. Which is best
/// depends on the scan: 0 = x.
using AxisOrder = std::array<std::uint8_t, 3>;
inline constexpr AxisOrder kStraightOrder = {0, 1, 2};

}  // namespace octavo
