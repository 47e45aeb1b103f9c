// Turns and scales as they are typed.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "octavo/ops/grid/axis_turn.h"

namespace octavo::cli {

/// The rotations, "z:90" (90, 180, 270 or -90), and then the mirrors, "x", each in its order.
/// Throws Error{invalid_argument}
AxisTurn parse_turn(const std::vector<std::string>& rotations,
                    const std::vector<std::string>& mirrors);

/// A power of two, up or down.
struct Scale {
  std::int64_t factor = 2;
  bool is_up = true;
  int doublings() const { return std::countr_zero(static_cast<std::uint64_t>(factor)); }
};

/// "4" is 4 and up, "1/4" is 4 and down; up to 64.
/// Throws Error{invalid_argument}
Scale parse_scale(const std::string& text);

}  // namespace octavo::cli
