// Values of several channels that alternate: red, green, blue, red, green, blue, ...
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace octavo {

/// How values alternate, and which of them is taken.
struct Alternation {
  std::size_t value_bytes = 1;
  std::int64_t count = 1;  ///< values at each voxel
  std::int64_t index = 0;  ///< from 0, below count
};

/// Fills `values` with one of each `count` values of `several`.
/// Requires whole `values`, and `several` that are at least count times as long.
void take_alternating(const Alternation& alternation, std::span<const std::byte> several,
                      std::span<std::byte> values);

}  // namespace octavo
