#include "octavo/render/cubes/face_raster.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace octavo {

namespace {

// Products of a slope and a distance are off by less, in units.
constexpr double kDoubt = 1.0 / 1024;

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

std::int64_t divided_up(std::int64_t dividend, std::int64_t divisor) {
  const std::int64_t quotient = dividend / divisor;
  return quotient + (dividend % divisor > 0 ? 1 : 0);
}

}  // namespace

CubeShape cube_shape(const View& view, int level) {
  CubeShape shape;
  const std::int64_t side = std::int64_t{1} << level;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const PlanePoint edge = flat(view.axes[a] * side);
    shape.lowest =
        plus(shape.lowest, {std::min<std::int64_t>(edge.x, 0), std::min<std::int64_t>(edge.y, 0)});
    shape.highest =
        plus(shape.highest, {std::max<std::int64_t>(edge.x, 0), std::max<std::int64_t>(edge.y, 0)});
    if (view.nearness[a] != 0) {
      shape.faces[static_cast<std::size_t>(shape.face_count++)] = face_across(view, axis, side);
    }
  }
  return shape;
}

PixelRows::PixelRows(const View& view, std::int64_t begin, std::int64_t end, std::uint32_t pixel)
    : width_(view.width),
      begin_(begin),
      end_(end),
      bits_(view.fraction_bits),
      half_(std::int64_t{1} << (bits_ - 1)),
      pixels_per_unit_(std::ldexp(1.0, -bits_)),
      doubt_(kDoubt * pixels_per_unit_),
      pixels_(static_cast<std::size_t>(width_ * (end - begin)), pixel) {}

std::int64_t PixelRows::exact_crossing(const PlanePoint& from, const PlanePoint& edge,
                                       std::int64_t down) const {
  return pixel_from(from.x + divided_up(down * edge.x, edge.y));
}

}  // namespace octavo
