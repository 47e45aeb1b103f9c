#include "octavo/render/rays/mesh_raster.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace octavo {

namespace {

constexpr std::int64_t kPixelUnits = 256;
constexpr std::uint32_t kAllPlaces = (1u << kPlacesInPixel) - 1;

std::int64_t rounded_units(double pixels) { return std::llround(pixels * kPixelUnits); }

}  // namespace

PolygonEdges::PolygonEdges(std::span<const ScreenPoint> corners) : count_(corners.size()) {
  std::array<std::array<std::int64_t, 2>, kMostCorners> at{};
  for (std::size_t i = 0; i < count_; ++i) {
    at[i] = {rounded_units(corners[i].x), rounded_units(corners[i].y)};
    for (std::size_t axis = 0; axis < 2; ++axis) {
      low_[axis] = i == 0 ? at[i][axis] : std::min(low_[axis], at[i][axis]);
      high_[axis] = i == 0 ? at[i][axis] : std::max(high_[axis], at[i][axis]);
    }
  }
  std::int64_t twice_area = 0;
  for (std::size_t i = 1; i + 1 < count_; ++i) {
    twice_area += (at[i][0] - at[0][0]) * (at[i + 1][1] - at[0][1]) -
                  (at[i][1] - at[0][1]) * (at[i + 1][0] - at[0][0]);
  }
  has_area_ = twice_area != 0;
  const std::int64_t turn = twice_area > 0 ? 1 : -1;
  for (std::size_t i = 0; i < count_; ++i) {
    const auto& a = at[i];
    const auto& b = at[(i + 1) % count_];
    Edge& edge = edges_[i];
    edge.across = -(b[1] - a[1]) * turn;
    edge.down = (b[0] - a[0]) * turn;
    edge.offset = -(edge.across * a[0] + edge.down * a[1]);
    // Of two polygons that share an edge one has what lies on it.
    const bool is_owner = edge.across > 0 || (edge.across == 0 && edge.down >= 0);
    if (!is_owner) --edge.offset;
    edge.reach = (std::abs(edge.across) + std::abs(edge.down)) * kPixelUnits / 2;
  }
}

std::array<std::int64_t, 2> PolygonEdges::columns() const {
  return {low_[0] >> 8, (high_[0] >> 8) + 1};
}

std::array<std::int64_t, 2> PolygonEdges::rows() const {
  return {low_[1] >> 8, (high_[1] >> 8) + 1};
}

std::uint32_t PolygonEdges::mask(std::int64_t column, std::int64_t row) const {
  const std::int64_t x = column * kPixelUnits;
  const std::int64_t y = row * kPixelUnits;
  std::uint32_t mask = kAllPlaces;
  for (std::size_t i = 0; i < count_; ++i) {
    const Edge& edge = edges_[i];
    const std::int64_t first = edge.across * x + edge.down * y + edge.offset;
    const std::int64_t middle = first + (edge.across + edge.down) * (kPixelUnits / 2);
    if (middle >= edge.reach) continue;
    if (middle < -edge.reach) return 0;
    for (std::size_t place = 0; place < kPlacesInPixel; ++place) {
      const std::int64_t there =
          first + edge.across * kPixelPlaces.x[place] + edge.down * kPixelPlaces.y[place];
      if (there < 0) mask &= ~(1u << place);
    }
  }
  return mask;
}

}  // namespace octavo
