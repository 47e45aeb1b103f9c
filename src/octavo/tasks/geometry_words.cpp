#include "octavo/tasks/geometry_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "octavo/core/text.h"

namespace octavo {

namespace {

constexpr double kTiltShownDegrees = 0.1;

struct BodyAxis {
  std::size_t component = 0;  // 0 left-right, 1 front-back, 2 feet-head
  bool is_positive = true;
  double tilt_degrees = 0;
};

BodyAxis body_axis_of(const Geometry& geometry, std::size_t index_axis) {
  BodyAxis axis;
  double largest = 0;
  for (std::size_t row = 0; row < 3; ++row) {
    const double v = geometry.direction[row * 3 + index_axis];
    if (std::abs(v) <= largest) continue;
    largest = std::abs(v);
    axis.component = row;
    axis.is_positive = v > 0;
  }
  axis.tilt_degrees = std::acos(std::min(1.0, largest)) * 180 / std::numbers::pi;
  return axis;
}

const char* run_words(const BodyAxis& axis) {
  static constexpr std::array<std::array<const char*, 2>, 3> kWords = {{
      {"left to right", "right to left"},
      {"back to front", "front to back"},
      {"head to feet", "feet to head"},
  }};
  return kWords[axis.component][axis.is_positive ? 1 : 0];
}

}  // namespace

std::string orientation_words(const Geometry& geometry) {
  static constexpr std::array<const char*, 3> kSlices = {"sagittal", "coronal", "axial"};
  const std::array<BodyAxis, 3> axes = {body_axis_of(geometry, 0), body_axis_of(geometry, 1),
                                        body_axis_of(geometry, 2)};
  std::string words =
      fmt::format("{} slices; x runs {}, y {}, z {}", kSlices[axes[2].component],
                  run_words(axes[0]), run_words(axes[1]), run_words(axes[2]));
  const double tilt =
      std::max({axes[0].tilt_degrees, axes[1].tilt_degrees, axes[2].tilt_degrees});
  if (tilt > kTiltShownDegrees) words += fmt::format(" (tilted {:.1f} degrees)", tilt);
  return words;
}

Point3 field_of_view_mm(const Geometry& geometry, const Size3& size) {
  return {geometry.spacing_mm[0] * static_cast<double>(size.x),
          geometry.spacing_mm[1] * static_cast<double>(size.y),
          geometry.spacing_mm[2] * static_cast<double>(size.z)};
}

BoxMm world_box(const Box& box, const Geometry& geometry) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  BoxMm world{{kInfinity, kInfinity, kInfinity}, {-kInfinity, -kInfinity, -kInfinity}};
  for (int corner = 0; corner < 8; ++corner) {
    Point3 index{};
    for (int axis = 0; axis < 3; ++axis) {
      const std::int64_t end = (corner >> axis & 1) != 0 ? box.hi[axis] : box.lo[axis];
      index[static_cast<std::size_t>(axis)] = static_cast<double>(end) - 0.5;
    }
    const Point3 at = geometry.to_world(index);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      world.lo[axis] = std::min(world.lo[axis], at[axis]);
      world.hi[axis] = std::max(world.hi[axis], at[axis]);
    }
  }
  return world;
}

std::string extent_text(const Geometry& geometry, const Size3& size) {
  const BoxMm world = world_box(box_of(size), geometry);
  std::string text;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    text += fmt::format("{}{}:{}", axis == 0 ? "" : ",", number_text(world.lo[axis]),
                        number_text(world.hi[axis]));
  }
  return text;
}

double largest_shift_mm(const Geometry& a, const Geometry& b, const Size3& size) {
  double largest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Point3 index{};
    for (int axis = 0; axis < 3; ++axis) {
      index[static_cast<std::size_t>(axis)] =
          (corner >> axis & 1) != 0 ? static_cast<double>(size[axis] - 1) : 0;
    }
    const Point3 p = a.to_world(index);
    const Point3 q = b.to_world(index);
    largest = std::max(largest, std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]));
  }
  return largest;
}

double shift_tolerance_mm(const Geometry& geometry) {
  return 1e-3 * *std::min_element(geometry.spacing_mm.begin(), geometry.spacing_mm.end());
}

}  // namespace octavo
