#include "octavo/render/cubes/face_raster.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace octavo {

namespace {

// Products of a slope and a distance are off by less, in units.
constexpr double kDoubt = 1.0 / 1024;

// Pixels: longer than any picture is wide.
constexpr double kLongestSpine = 1 << 16;

PlanePoint flat(const Place& place) { return {place.x, place.y}; }

PlanePoint plus(const PlanePoint& a, const PlanePoint& b) { return {a.x + b.x, a.y + b.y}; }

double slope_of(const PlanePoint& edge) {
  return edge.y == 0 ? 0 : static_cast<double>(edge.x) / static_cast<double>(edge.y);
}

/// Lets an edge lead down, or to the right where it is level.
void turn_down(PlanePoint& top, PlanePoint& edge) {
  if (edge.y > 0 || (edge.y == 0 && edge.x > 0)) return;
  top = plus(top, edge);
  edge = {-edge.x, -edge.y};
}

PlanePoint times(const PlanePoint& p, std::int64_t n) { return {p.x * n, p.y * n}; }

Face face_across(const View& view, int axis, std::int64_t side) {
  const auto a = static_cast<std::size_t>(axis);
  const Place& along_b = view.axes[(a + 1) % 3];
  const Place& along_c = view.axes[(a + 2) % 3];
  const Place corner = view.nearness[a] > 0 ? view.axes[a] : Place{};
  Face face;
  face.axis = axis;
  face.top = flat(corner);
  face.left = flat(along_b);
  face.right = flat(along_c);
  turn_down(face.top, face.left);
  turn_down(face.top, face.right);
  if (face.left.x * face.right.y > face.right.x * face.left.y) std::swap(face.left, face.right);
  face.left_slope = slope_of(face.left);
  face.right_slope = slope_of(face.right);
  // The face of a voxel, enlarged.
  face.top = times(face.top, side);
  face.left = times(face.left, side);
  face.right = times(face.right, side);
  face.depth = corner.depth * side + (along_b.depth + along_c.depth) * side / 2;
  return face;
}

/// Twice the area between two edges, in square units.
double area_between(const PlanePoint& a, const PlanePoint& b) {
  return std::abs(static_cast<double>(a.x) * static_cast<double>(b.y) -
                  static_cast<double>(a.y) * static_cast<double>(b.x));
}

double length_of(const PlanePoint& edge) {
  return std::hypot(static_cast<double>(edge.x), static_cast<double>(edge.y));
}

/// The width of the hexagon that three edges span, units: it is narrowest across one of its sides.
double width_of(const std::array<PlanePoint, 3>& edges) {
  double width = std::numeric_limits<double>::infinity();
  for (const PlanePoint& edge : edges) {
    if (length_of(edge) == 0) continue;
    double across = 0;
    for (const PlanePoint& other : edges) across += area_between(edge, other);
    width = std::min(width, across / length_of(edge));
  }
  return std::isfinite(width) ? width : 0;
}

/// pixel  its side, units
std::vector<PlanePoint> spine_of(const std::array<PlanePoint, 3>& edges, double pixel) {
  // A disk as wide as the diagonal of a pixel holds the center of one wherever it lies.
  if (width_of(edges) >= std::numbers::sqrt2 * pixel) return {};

  // Along the longest edge, as far as all three reach.
  const PlanePoint& longest =
      *std::max_element(edges.begin(), edges.end(), [](const auto& a, const auto& b) {
        return length_of(a) < length_of(b);
      });
  const double length = std::max(1.0, length_of(longest));
  const double x = static_cast<double>(longest.x) / length;
  const double y = static_cast<double>(longest.y) / length;
  PlanePoint whole;
  double reach = 0;
  for (const PlanePoint& edge : edges) {
    whole = plus(whole, edge);
    reach += std::abs(static_cast<double>(edge.x) * x + static_cast<double>(edge.y) * y);
  }
  const auto count =
      static_cast<std::int64_t>(std::clamp(std::ceil(reach / pixel), 1.0, kLongestSpine));
  std::vector<PlanePoint> spine;
  for (std::int64_t i = 0; i < count; ++i) {
    const double at = ((static_cast<double>(i) + 0.5) / static_cast<double>(count) - 0.5) * reach;
    spine.push_back({std::llround(static_cast<double>(whole.x) / 2 + at * x),
                     std::llround(static_cast<double>(whole.y) / 2 + at * y)});
  }
  return spine;
}

std::int64_t divided_up(std::int64_t dividend, std::int64_t divisor) {
  const std::int64_t quotient = dividend / divisor;
  return quotient + (dividend % divisor > 0 ? 1 : 0);
}

}  // namespace

CubeShape cube_shape(const View& view, int level) {
  CubeShape shape;
  const std::int64_t side = std::int64_t{1} << level;
  std::array<PlanePoint, 3> edges;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const PlanePoint edge = flat(view.axes[a] * side);
    edges[a] = edge;
    shape.lowest =
        plus(shape.lowest, {std::min<std::int64_t>(edge.x, 0), std::min<std::int64_t>(edge.y, 0)});
    shape.highest =
        plus(shape.highest, {std::max<std::int64_t>(edge.x, 0), std::max<std::int64_t>(edge.y, 0)});
    if (view.nearness[a] != 0) {
      shape.faces[static_cast<std::size_t>(shape.face_count++)] = face_across(view, axis, side);
    }
  }
  shape.spine = spine_of(edges, std::ldexp(1.0, view.fraction_bits));
  return shape;
}

const Face& CubeShape::largest_face(unsigned axes) const {
  const Face* largest = nullptr;
  double most = -1;
  for (int i = 0; i < face_count; ++i) {
    const Face& face = faces[static_cast<std::size_t>(i)];
    const double area = face.area();
    if ((axes >> face.axis & 1) == 0 || area <= most) continue;
    largest = &face;
    most = area;
  }
  return *largest;
}

PixelRows::PixelRows(const View& view, std::int64_t begin, std::int64_t end, std::uint32_t pixel,
                     bool has_spines)
    : width_(view.width),
      begin_(begin),
      end_(end),
      bits_(view.fraction_bits),
      half_(std::int64_t{1} << (bits_ - 1)),
      below_(has_spines ? half_ - 1 : 0),
      above_(has_spines ? half_ + 1 : 0),
      pixels_per_unit_(std::ldexp(1.0, -bits_)),
      doubt_(kDoubt * pixels_per_unit_),
      pixels_(static_cast<std::size_t>(width_ * (end - begin)), pixel) {}

std::int64_t PixelRows::exact_crossing(const PlanePoint& from, const PlanePoint& edge,
                                       std::int64_t down) const {
  return pixel_from(from.x + divided_up(down * edge.x, edge.y));
}

}  // namespace octavo
