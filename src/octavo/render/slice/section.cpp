#include "octavo/render/slice/section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/render/slice_orientation.h"

namespace octavo {

namespace {

/// The side of a square pixel: `finest`, divided so that `longest` has `minimum_side` pixels.
double pixel_of(double finest, double longest, std::int64_t minimum_side) {
  const double enlargement = std::ceil(static_cast<double>(minimum_side) * finest / longest);
  return finest / std::max(1.0, enlargement);
}

/// A number of pixels, at least 1, of which few enough fit into a picture.
std::int64_t whole_pixels(double count) {
  constexpr double kMostPixels = 1 << 28;
  if (count <= kMostPixels) return std::max<std::int64_t>(1, std::llround(count));
  throw Error(ErrorKind::invalid_argument,
              "is too flat to be drawn: " + number_text(count) + " pixels of its finest spacing "
              "side by side");
}

/// One index axis of a slice in its picture: pixel p lies at index first + p * step.
struct PixelAxis {
  std::int64_t pixels = 1;
  double first = 0;
  double step = 1;
};

PixelAxis pixel_axis(std::int64_t samples, double length_mm, double pixel_mm, bool flips) {
  PixelAxis axis;
  axis.pixels = whole_pixels(length_mm / pixel_mm);
  axis.step = static_cast<double>(samples) / static_cast<double>(axis.pixels);
  axis.first = axis.step / 2 - 0.5;
  if (flips) {
    axis.first = static_cast<double>(samples - 1) - axis.first;
    axis.step = -axis.step;
  }
  return axis;
}

[[noreturn]] void reject(const char* what, std::int64_t value, std::int64_t end) {
  throw Error(ErrorKind::invalid_argument, std::string(what) + " " + std::to_string(value) +
                                               "; it must be between 0 and " +
                                               std::to_string(end - 1));
}

/// The axes of the picture of a plane, by its unit normal.
struct PlaneAxes {
  Point3 right{};
  Point3 down{};
};

/// As for the slice that is nearest: axial from the feet with the front up, coronal from the front
/// and sagittal from the left with the head up.
PlaneAxes plane_axes(const Point3& normal) {
  const Point3 size = {std::abs(normal[0]), std::abs(normal[1]), std::abs(normal[2])};
  const bool is_axial = size[2] >= size[0] && size[2] >= size[1];
  const bool is_coronal = !is_axial && size[1] >= size[0];
  const Point3 viewer = is_axial     ? Point3{0, 0, -1}
                        : is_coronal ? Point3{0, -1, 0}
                                     : Point3{1, 0, 0};
  const Point3 toward = scaled(normal, dot(normal, viewer) < 0 ? -1 : 1);
  const Point3 top = is_axial ? Point3{0, -1, 0} : Point3{0, 0, 1};
  const Point3 across = cross(top, toward);
  const Point3 right = scaled(across, 1 / std::sqrt(dot(across, across)));
  return {right, scaled(cross(toward, right), -1)};
}

/// Where the edges of a grid meet a plane.
std::vector<Point3> crossings(const Geometry& geometry, const Size3& size, const Point3& point,
                              const Point3& normal) {
  std::vector<Point3> found;
  for (int axis = 0; axis < 3; ++axis) {
    for (int corner = 0; corner < 4; ++corner) {
      Point3 from{}, to{};
      for (int a = 0; a < 3; ++a) {
        const auto i = static_cast<std::size_t>(a);
        const bool is_high = (corner >> (a > axis ? a - 1 : a) & 1) != 0;
        from[i] = to[i] = is_high ? static_cast<double>(size[a]) - 0.5 : -0.5;
        if (a == axis) {
          from[i] = -0.5;
          to[i] = static_cast<double>(size[a]) - 0.5;
        }
      }
      from = geometry.to_world(from);
      to = geometry.to_world(to);
      const double before = dot(difference(from, point), normal);
      const double after = dot(difference(to, point), normal);
      if (before == 0 && after == 0) {
        found.push_back(from);
        found.push_back(to);
      } else if ((before <= 0) != (after <= 0) || before == 0 || after == 0) {
        const double share = before / (before - after);
        found.push_back(sum(from, scaled(difference(to, from), share)));
      }
    }
  }
  return found;
}

struct Extent {
  double low = 0;
  double high = 0;
  double length() const { return high - low; }
  double middle() const { return (low + high) / 2; }
};

Extent extent_along(const std::vector<Point3>& points, const Point3& from, const Point3& along) {
  Extent extent{dot(difference(points.front(), from), along),
                dot(difference(points.front(), from), along)};
  for (const Point3& p : points) {
    const double at = dot(difference(p, from), along);
    extent.low = std::min(extent.low, at);
    extent.high = std::max(extent.high, at);
  }
  return extent;
}

EdgeLetters letters_of(const PixelMap& world) {
  const auto unit = [](const Point3& step) { return scaled(step, 1 / std::sqrt(dot(step, step))); };
  const Point3 right = unit(world.across);
  const Point3 down = unit(world.down);
  return {side_letters(scaled(right, -1)), side_letters(right), side_letters(scaled(down, -1)),
          side_letters(down)};
}

/// A number without the rounding of a way through world space.
double cleaned(double value, double tolerance) {
  const double whole = std::round(value);
  return std::abs(value - whole) < tolerance ? whole : value;
}

}  // namespace

PlaneSection axis_section(const Geometry& geometry, const Size3& size, int axis, std::int64_t index,
                     std::int64_t minimum_side) {
  if (axis < 0 || axis > 2) reject("axis", axis, 3);
  if (index < 0 || index >= size[axis]) reject("slice", index, size[axis]);
  const SliceOrientation o = slice_orientation(geometry, axis);
  const auto across_axis = static_cast<std::size_t>(o.across);
  const auto down_axis = static_cast<std::size_t>(o.down);
  const double across_mm = geometry.spacing_mm[across_axis] * static_cast<double>(size[o.across]);
  const double down_mm = geometry.spacing_mm[down_axis] * static_cast<double>(size[o.down]);
  PlaneSection section;
  section.pixel_mm =
      pixel_of(std::min(geometry.spacing_mm[across_axis], geometry.spacing_mm[down_axis]),
               std::max(across_mm, down_mm), minimum_side);
  const PixelAxis across = pixel_axis(size[o.across], across_mm, section.pixel_mm, o.flips_across);
  const PixelAxis down = pixel_axis(size[o.down], down_mm, section.pixel_mm, o.flips_down);
  section.width = across.pixels;
  section.height = down.pixels;
  Point3 first{};
  first[static_cast<std::size_t>(axis)] = static_cast<double>(index);
  first[across_axis] = across.first;
  first[down_axis] = down.first;
  Point3 right = first;
  right[across_axis] += across.step;
  Point3 below = first;
  below[down_axis] += down.step;
  section.world.origin = geometry.to_world(first);
  section.world.across = difference(geometry.to_world(right), section.world.origin);
  section.world.down = difference(geometry.to_world(below), section.world.origin);
  section.letters = letters_of(section.world);
  return section;
}

PlaneSection oblique_section(const Geometry& geometry, const Size3& size, const CutPlane& plane,
                        std::int64_t minimum_side) {
  const double length = std::sqrt(dot(plane.normal, plane.normal));
  if (!(length > 0) || !std::isfinite(length) || !std::isfinite(dot(plane.point_mm, {1, 1, 1}))) {
    throw Error(ErrorKind::invalid_argument,
                "a plane needs a point, and a normal that is not 0 for its direction")
        .with_field("plane.normal");
  }
  const Point3 normal = scaled(plane.normal, 1 / length);
  const std::vector<Point3> border = crossings(geometry, size, plane.point_mm, normal);
  if (border.empty()) {
    throw Error(ErrorKind::invalid_argument, "the plane does not meet the volume");
  }

  // Fit the picture around the part of the plane that lies in the volume.
  const PlaneAxes axes = plane_axes(normal);
  const Extent across = extent_along(border, plane.point_mm, axes.right);
  const Extent down = extent_along(border, plane.point_mm, axes.down);
  const double finest = *std::min_element(geometry.spacing_mm.begin(), geometry.spacing_mm.end());
  PlaneSection section;
  section.pixel_mm =
      pixel_of(finest, std::max({across.length(), down.length(), finest}), minimum_side);
  const auto pixels = [&](const Extent& extent) {
    return whole_pixels(std::ceil(extent.length() / section.pixel_mm - 1e-6));
  };
  section.width = pixels(across);
  section.height = pixels(down);
  section.world.across = scaled(axes.right, section.pixel_mm);
  section.world.down = scaled(axes.down, section.pixel_mm);
  const double first_x =
      across.middle() - static_cast<double>(section.width - 1) / 2 * section.pixel_mm;
  const double first_y =
      down.middle() - static_cast<double>(section.height - 1) / 2 * section.pixel_mm;
  section.world.origin =
      sum(plane.point_mm, sum(scaled(axes.right, first_x), scaled(axes.down, first_y)));
  section.letters = letters_of(section.world);
  return section;
}

PixelMap index_map(const PixelMap& world, const Geometry& geometry) {
  constexpr double kStepTolerance = 1e-9;  // an index drifts less over any picture
  constexpr double kPlaceTolerance = 1e-6;
  PixelMap map;
  map.origin = geometry.to_index(world.origin);
  map.across = difference(geometry.to_index(sum(world.origin, world.across)), map.origin);
  map.down = difference(geometry.to_index(sum(world.origin, world.down)), map.origin);
  for (std::size_t a = 0; a < 3; ++a) {
    map.across[a] = cleaned(map.across[a], kStepTolerance);
    map.down[a] = cleaned(map.down[a], kStepTolerance);
    if (map.across[a] == 0 && map.down[a] == 0) {
      map.origin[a] = cleaned(map.origin[a], kPlaceTolerance);
    }
  }
  return map;
}

}  // namespace octavo
