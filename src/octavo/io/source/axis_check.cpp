#include "octavo/io/source/axis_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/io/source/described_source.h"

namespace octavo {

const char* axis_name(std::size_t axis) {
  static constexpr std::array<const char*, 3> kNames = {"x", "y", "z"};
  return kNames.at(axis);
}

bool is_perpendicular(const Geometry& geometry) noexcept {
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(std::abs(axis_cosine(geometry, a, (a + 1) % 3)) <= kAxisTolerance)) return false;
  }
  return true;
}

void reject_shear(const Geometry& geometry, const std::string& field, const std::string& path) {
  for (std::size_t b = 1; b < 3; ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const double cosine = axis_cosine(geometry, a, b);
      if (!(std::abs(cosine) > kAxisTolerance)) continue;
      const double degrees = std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / std::numbers::pi;
      throw Error(ErrorKind::source_rejected,
                  field + ": the grid is sheared, its axes " + axis_name(a) + " and " +
                      axis_name(b) + " stand at " + precise_text(degrees) +
                      " degrees, 90 expected: lengths and volumes measured in it would be wrong; "
                      "resample it to perpendicular axes first",
                  path);
    }
  }
}

}  // namespace octavo
