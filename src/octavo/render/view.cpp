#include "octavo/render/view.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"

namespace octavo {

namespace {

constexpr double kFilledShare = 0.9;           // of the picture, by what is shown
constexpr double kFarthestUnits = double(1 << 30);  // units
constexpr int kMostFractionBits = 24;

/// One voxel along an index axis, mm.
Point3 step_mm(const Geometry& geometry, std::size_t axis) {
  const auto& d = geometry.direction;
  return scaled({d[axis], d[3 + axis], d[6 + axis]}, geometry.spacing_mm[axis]);
}

/// Up is the head, or the front of the body when one looks along it.
Viewpoint upright(const Point3& toward) {
  constexpr Point3 kHead = {0, 0, 1};
  constexpr Point3 kFront = {0, -1, 0};
  constexpr double kMinimumSine = 1e-3;
  const Point3 side = cross(kHead, toward);
  const Point3 right = dot(side, side) > kMinimumSine * kMinimumSine ? side : cross(kFront, toward);
  return {toward, unit(cross(toward, unit(right)))};
}

Point3 right_of(const Viewpoint& viewpoint) { return cross(viewpoint.up, viewpoint.toward); }

void check_frame(const ViewFrame& frame) {
  const bool has_pixels = frame.width > 0 && frame.height > 0 &&
                          std::max(frame.width, frame.height) <= ViewFrame::kLongestSide;
  if (!has_pixels) {
    throw Error(ErrorKind::invalid_argument, "a picture of " + std::to_string(frame.width) + " x " +
                                                 std::to_string(frame.height) +
                                                 " pixels; sides must be between 1 and " +
                                                 std::to_string(ViewFrame::kLongestSide));
  }
  const auto is_length = [](double value) { return std::isfinite(value) && value > 0; };
  if (!is_length(frame.zoom) || !is_length(frame.pixel_mm.value_or(1))) {
    throw Error(ErrorKind::invalid_argument, "the zoom must be greater than 0");
  }
}

/// A place in pixels, before it is rounded.
struct Spot {
  double x = 0;
  double y = 0;
  double depth = 0;

  Spot plus(const Spot& s, double times) const {
    return {x + s.x * times, y + s.y * times, depth + s.depth * times};
  }
};

/// The farthest that a corner of the volume lies from the picture's upper left, pixels.
double farthest(const Spot& origin, const std::array<Spot, 3>& axes, const Size3& size) {
  double most = 0;
  for (int corner = 0; corner < 8; ++corner) {
    Spot at = origin;
    for (int axis = 0; axis < 3; ++axis) {
      const auto length = static_cast<double>(size[axis]);
      at = at.plus(axes[static_cast<std::size_t>(axis)], (corner >> axis & 1) != 0 ? length : 0);
    }
    most = std::max({most, std::abs(at.x), std::abs(at.y), std::abs(at.depth)});
  }
  return most;
}

Place rounded(const Spot& spot, double unit) {
  return {std::llround(spot.x * unit), std::llround(spot.y * unit),
          std::llround(spot.depth * unit)};
}

int sign_of(std::int64_t value) { return value > 0 ? 1 : value < 0 ? -1 : 0; }

/// The direction in index space that falls on one point of the picture, towards the viewer.
std::array<int, 3> nearness_of(const std::array<Place, 3>& axes) {
  std::array<int, 3> signs{};
  double depth = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Place& b = axes[(axis + 1) % 3];
    const Place& c = axes[(axis + 2) % 3];
    const std::int64_t component = b.x * c.y - c.x * b.y;
    signs[axis] = sign_of(component);
    depth += static_cast<double>(component) * static_cast<double>(axes[axis].depth);
  }
  if (!(depth != 0)) {
    throw Error(ErrorKind::invalid_argument,
                "voxels would be too small or too flat to be seen; take a larger picture");
  }
  if (depth < 0) {
    for (int& sign : signs) sign = -sign;
  }
  return signs;
}

/// A side of the patient.
struct PatientSide {
  std::string_view name;
  std::size_t axis;
  double sign;
};
constexpr PatientSide kSides[] = {{"right", 0, -1}, {"left", 0, 1},    {"front", 1, -1},
                                  {"back", 1, 1},   {"bottom", 2, -1}, {"top", 2, 1}};

}  // namespace

Viewpoint viewpoint_along(const Geometry& geometry, const Point3& steps) {
  Point3 toward{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Point3 step = step_mm(geometry, axis);
    for (std::size_t i = 0; i < 3; ++i) toward[i] += step[i] * steps[axis];
  }
  const double length = std::sqrt(dot(toward, toward));
  if (!std::isfinite(length) || length == 0) {
    throw Error(ErrorKind::invalid_argument, "a direction needs a step along one axis at least");
  }
  return upright(scaled(toward, 1 / length));
}

std::optional<Viewpoint> find_viewpoint(std::string_view name) {
  Point3 toward{};
  while (true) {
    const std::size_t end = std::min(name.find('-'), name.size());
    const auto side = std::ranges::find(kSides, name.substr(0, end), &PatientSide::name);
    if (side == std::end(kSides) || toward[side->axis] != 0) return std::nullopt;
    toward[side->axis] = side->sign;
    if (end == name.size()) return upright(unit(toward));
    name.remove_prefix(end + 1);
  }
}

std::vector<std::string> viewpoint_names() {
  std::vector<std::string> names;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    // Alone, and joined to what there is of the axes before.
    const std::vector<std::string> before = names;
    for (const PatientSide& side : kSides) {
      if (side.axis != axis) continue;
      names.emplace_back(side.name);
      for (const std::string& name : before) names.push_back(name + "-" + std::string(side.name));
    }
  }
  return names;
}

Viewpoint viewpoint_at(double azimuth_degrees, double elevation_degrees) {
  if (!std::isfinite(azimuth_degrees) || !std::isfinite(elevation_degrees)) {
    throw Error(ErrorKind::invalid_argument, "azimuth and elevation must be finite");
  }
  const double azimuth = azimuth_degrees * std::numbers::pi / 180;
  const double elevation = elevation_degrees * std::numbers::pi / 180;
  const double level = std::cos(elevation);
  const double rise = std::sin(elevation);
  return {{std::sin(azimuth) * level, -std::cos(azimuth) * level, rise},
          {-std::sin(azimuth) * rise, std::cos(azimuth) * rise, level}};
}

Viewpoint turned(const Viewpoint& viewpoint, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  const auto turn = [&](const Point3& p) {
    return Point3{p[0] * std::cos(angle) - p[1] * std::sin(angle),
                  p[0] * std::sin(angle) + p[1] * std::cos(angle), p[2]};
  };
  return {turn(viewpoint.toward), turn(viewpoint.up)};
}

double fitting_pixel_mm(const Geometry& geometry, const Box& shown, const Viewpoint& viewpoint,
                        const ViewFrame& frame) {
  check_frame(frame);
  const Point3 right = right_of(viewpoint);
  double width_mm = 0;
  double height_mm = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const Point3 step = step_mm(geometry, static_cast<std::size_t>(axis));
    const auto count = static_cast<double>(shown.size()[axis]);
    width_mm += std::abs(dot(step, right)) * count;
    height_mm += std::abs(dot(step, viewpoint.up)) * count;
  }
  return std::max(width_mm / static_cast<double>(frame.width),
                  height_mm / static_cast<double>(frame.height)) /
         kFilledShare;
}

Point3 middle_of(const Box& voxels) {
  Point3 middle;
  for (int axis = 0; axis < 3; ++axis) {
    middle[static_cast<std::size_t>(axis)] =
        static_cast<double>(voxels.lo[axis] + voxels.hi[axis]) / 2;
  }
  return middle;
}

View make_view(const Geometry& geometry, const Size3& size, const Box& shown,
               const Viewpoint& viewpoint, const ViewFrame& frame) {
  ViewFrame scaled = frame;
  scaled.pixel_mm =
      frame.pixel_mm.value_or(fitting_pixel_mm(geometry, shown, viewpoint, frame));
  return view_around(geometry, size, middle_of(shown), viewpoint, scaled);
}

View view_around(const Geometry& geometry, const Size3& size, const Point3& middle,
                 const Viewpoint& viewpoint, const ViewFrame& frame) {
  check_frame(frame);
  View view;
  view.width = frame.width;
  view.height = frame.height;
  view.right = right_of(viewpoint);
  view.up = viewpoint.up;
  view.toward = viewpoint.toward;
  view.middle = middle;
  view.pixel_mm = frame.pixel_mm.value() / frame.zoom;

  // Project the axes, and put the middle of what is shown into the middle of the picture.
  std::array<Spot, 3> axes;
  Spot origin{static_cast<double>(frame.width) / 2, static_cast<double>(frame.height) / 2, 0};
  for (int axis = 0; axis < 3; ++axis) {
    const Point3 step = step_mm(geometry, static_cast<std::size_t>(axis));
    Spot& spot = axes[static_cast<std::size_t>(axis)];
    spot = {dot(step, view.right) / view.pixel_mm, -dot(step, view.up) / view.pixel_mm,
            dot(step, view.toward) / view.pixel_mm};
    origin = origin.plus(spot, -middle[static_cast<std::size_t>(axis)]);
  }

  // Round, as finely as the numbers allow.
  const double most = farthest(origin, axes, size);
  if (!(most * 2 < kFarthestUnits)) {
    throw Error(ErrorKind::limit_exceeded,
                "the zoom is too large; the volume would be 2^29 pixels long");
  }
  double units = 2;
  view.fraction_bits = 1;
  while (view.fraction_bits < kMostFractionBits && most * units * 2 < kFarthestUnits) {
    units *= 2;
    ++view.fraction_bits;
  }
  view.origin = rounded(origin, units);
  for (std::size_t axis = 0; axis < 3; ++axis) view.axes[axis] = rounded(axes[axis], units);
  view.nearness = nearness_of(view.axes);
  return view;
}

std::string side_letters(const Point3& direction) {
  constexpr double kClear = 0.38;  // the sine of 22 degrees
  std::array<std::size_t, 3> order = {0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const double of_a = std::abs(direction[a]);
    const double of_b = std::abs(direction[b]);
    return of_a != of_b ? of_a > of_b : a < b;
  });
  std::string letters;
  for (const std::size_t axis : order) {
    if (!letters.empty() && std::abs(direction[axis]) < kClear) break;
    letters += direction[axis] < 0 ? "RAI"[axis] : "LPS"[axis];
  }
  return letters;
}

EdgeLetters edge_letters(const View& view) {
  return {side_letters(scaled(view.right, -1)), side_letters(view.right), side_letters(view.up),
          side_letters(scaled(view.up, -1))};
}

bool is_seen_from_a_side(const View& view) {
  const EdgeLetters letters = edge_letters(view);
  return letters.left.size() == 1 && letters.top.size() == 1;
}

std::array<ViewAxis, 3> patient_axes(const View& view) {
  std::array<ViewAxis, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const double sign = view.toward[i] < -1e-9 ? -1 : 1;
    axes[i] = {std::string(1, sign < 0 ? "RAI"[i] : "LPS"[i]), sign * view.right[i],
               sign * view.up[i], sign * view.toward[i]};
  }
  return axes;
}

std::array<ViewAxis, 3> grid_axes(const View& view) {
  std::array<ViewAxis, 3> axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const Place& step = view.axes[i];
    const auto x = static_cast<double>(step.x);
    const auto y = static_cast<double>(step.y);
    const auto depth = static_cast<double>(step.depth);
    const double length = std::hypot(x, y, depth);
    axes[i] = {std::string(1, "xyz"[i]), x / length, -y / length, depth / length};
  }
  return axes;
}

}  // namespace octavo
