#include "octavo/render/rays/ray_shade.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr double kAmbientWidening = 0.5;   // radius of a cone by its length
constexpr double kLampWidening = 0.06;
constexpr double kAmbientReachShare = 0.25;  // of the diagonal
constexpr std::size_t kPairPadding = 8;      // bytes that are read behind the last pair
constexpr int kLitAround = 2;                // cells
constexpr double kAmbientBegin = 1.5;        // where cones begin, cells from the middle
constexpr double kLampBegin = 2.5;

/// The middles of the faces and the corners of a cube.
std::array<Point3, 14> cone_directions() {
  std::array<Point3, 14> directions{};
  std::size_t count = 0;
  for (int z = -1; z <= 1; ++z) {
    for (int y = -1; y <= 1; ++y) {
      for (int x = -1; x <= 1; ++x) {
        const int steps = std::abs(x) + std::abs(y) + std::abs(z);
        if (steps != 1 && steps != 3) continue;
        directions[count++] = unit({static_cast<double>(x), static_cast<double>(y),
                                    static_cast<double>(z)});
      }
    }
  }
  return directions;
}

std::size_t place_in_grid(const Size3& size, std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::size_t>((z * size.y + y) * size.x + x);
}

/// The opacity of a cell of twice the side for up to 2^3 cells each: their mean, each twice as
/// thick. What covers half of a cell takes half of the light, however dense it is.
std::vector<float> halved(const Size3& size, const std::vector<float>& cells, const Size3& half) {
  std::vector<float> means(static_cast<std::size_t>(half.voxel_count()));
  std::size_t to = 0;
  for (std::int64_t z = 0; z < half.z; ++z) {
    for (std::int64_t y = 0; y < half.y; ++y) {
      for (std::int64_t x = 0; x < half.x; ++x) {
        float sum = 0;
        for (int i = 0; i < 8; ++i) {
          const float passed = 1 - cells[place_in_grid(size, std::min(2 * x + (i & 1), size.x - 1),
                                     std::min(2 * y + (i >> 1 & 1), size.y - 1),
                                     std::min(2 * z + (i >> 2), size.z - 1))];
          sum += 1 - passed * passed;
        }
        means[to++] = sum / 8;
      }
    }
  }
  return means;
}

std::array<float, 3> middle_of(const Index3& cell) {
  return {static_cast<float>(cell.x), static_cast<float>(cell.y), static_cast<float>(cell.z)};
}

/// Nothing around the cells.
std::vector<float> with_border(const Size3& size, const std::vector<float>& cells) {
  const Size3 wide{size.x + 2, size.y + 2, size.z + 2};
  std::vector<float> bordered(static_cast<std::size_t>(wide.voxel_count()));
  auto from = cells.begin();
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, from += size.x) {
      std::copy_n(from, size.x, bordered.begin() + static_cast<std::ptrdiff_t>(place_in_grid(
                                                       wide, 1, y + 1, z + 1)));
    }
  }
  return bordered;
}

}  // namespace

RayShade::RayShade(ExtinctionGrid grid, const Progress& watcher) : geometry_(grid.geometry) {
  const Point3& spacing = geometry_.spacing_mm;
  side_mm_ = std::max({spacing[0], spacing[1], spacing[2]});
  double squared = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const double side = spacing[static_cast<std::size_t>(axis)] *
                        static_cast<double>(grid.size[axis]);
    squared += side * side;
  }
  reach_mm_ = std::sqrt(squared);
  for (float& cell : grid.per_mm) cell = -std::expm1(-cell * static_cast<float>(side_mm_));
  find_lit(grid.size, grid.per_mm);
  std::vector<float> cells = std::move(grid.per_mm);
  for (Size3 size = grid.size;;) {
    levels_.push_back({size, with_border(size, cells)});
    if (size.voxel_count() == 1) break;
    const Size3 half{(size.x + 1) / 2, (size.y + 1) / 2, (size.z + 1) / 2};
    cells = halved(size, cells, half);
    size = half;
  }
  std::vector<LightCone> cones;
  for (const Point3& direction : cone_directions()) {
    cones.push_back(cone(direction, kAmbientWidening, kAmbientBegin * side_mm_,
                         kAmbientReachShare * reach_mm_));
  }
  fill(ambient_, watcher, [&](const Index3& cell) {
    float sum = 0;
    for (const LightCone& cone : cones) sum += passed(middle_of(cell), cone);
    // Half of the cones at a plane surface are in what it bounds.
    return 2 * sum / static_cast<float>(cones.size());
  });
  direct_.assign(ambient_.size(), 255);
}

void RayShade::set_lamp(const Point3& toward_light, const Progress& watcher) {
  to_lamp_ = cone(toward_light, kLampWidening, kLampBegin * side_mm_, reach_mm_);
  fill(direct_, watcher, [&](const Index3& cell) {
    return kDeepestShadow + (1 - kDeepestShadow) * passed(middle_of(cell), to_lamp_);
  });
}

float RayShade::passed_to_lamp(const Point3& world) const {
  const Point3 at = geometry_.to_index(world);
  return passed({static_cast<float>(at[0]), static_cast<float>(at[1]), static_cast<float>(at[2])},
                to_lamp_);
}

ShadeTable RayShade::table(const Geometry& rays, bool has_ambient) {
  const Size3& size = levels_.front().size;
  // Of a single cell along an axis the next one is read and counts nothing.
  const auto behind = static_cast<std::size_t>(size.x * size.y + size.x);
  pairs_.assign(2 * (direct_.size() + behind) + kPairPadding, 255);
  for (std::size_t i = 0; i < direct_.size(); ++i) {
    if (has_ambient) pairs_[2 * i] = ambient_[i];
    pairs_[2 * i + 1] = direct_[i];
  }
  ShadeTable table;
  table.pairs = pairs_.data();
  table.row = static_cast<std::int32_t>(size.x);
  table.plane = static_cast<std::int32_t>(size.x * size.y);
  const Point3 first = geometry_.to_index(rays.origin_mm);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::int64_t last = size[static_cast<int>(axis)] - 1;
    table.last_cell[axis] = static_cast<std::int32_t>(std::max<std::int64_t>(last - 1, 0));
    table.highest[axis] = static_cast<float>(last);
    table.scale[axis] = static_cast<float>(rays.spacing_mm[axis] / geometry_.spacing_mm[axis]);
    table.offset[axis] = static_cast<float>(first[axis]);
  }
  return table;
}

float RayShade::at(const std::vector<std::uint8_t>& shares, const Index3& cell) const {
  return static_cast<float>(
             shares[place_in_grid(levels_.front().size, cell.x, cell.y, cell.z)]) /
         255;
}

/// Between the middles of cells around a place, in cells of the level; 0 outside the grid.
float RayShade::PyramidLevel::at(const std::array<float, 3>& place) const {
  std::array<std::int64_t, 3> cell{};
  std::array<float, 3> share{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto end = static_cast<float>(size[static_cast<int>(axis)]);
    if (!(place[axis] > -1 && place[axis] < end)) return 0;
    const float floor = std::floor(place[axis]);
    share[axis] = place[axis] - floor;
    cell[axis] = static_cast<std::int64_t>(floor) + 1;  // of the border around the cells
  }
  const std::int64_t row = size.x + 2;
  const std::int64_t plane = row * (size.y + 2);
  const float* const first = bordered.data() + cell[2] * plane + cell[1] * row + cell[0];
  const auto of_row = [&](std::int64_t by) {
    return first[by] + (first[by + 1] - first[by]) * share[0];
  };
  const auto of_plane = [&](std::int64_t by) {
    const float near = of_row(by);
    return near + (of_row(by + row) - near) * share[1];
  };
  const float near = of_plane(0);
  return near + (of_plane(plane) - near) * share[2];
}

/// widening       radius by length
/// begin, end     mm from the middle of a cell
RayShade::LightCone RayShade::cone(const Point3& direction, double widening, double begin,
                                   double end) const {
  Point3 cells_per_mm{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& d = geometry_.direction;
    cells_per_mm[axis] = (direction[0] * d[axis] + direction[1] * d[3 + axis] +
                          direction[2] * d[6 + axis]) /
                         geometry_.spacing_mm[axis];
  }
  LightCone cone;
  for (double t = begin; t < end;) {
    const double radius = std::max(side_mm_ / 2, widening * t);
    ConeStep& step = cone.emplace_back();
    step.level = static_cast<std::size_t>(
        std::clamp(std::lround(std::log2(2 * radius / side_mm_)), 0L,
                   static_cast<long>(levels_.size()) - 1));
    step.scale = static_cast<float>(std::ldexp(1.0, -static_cast<int>(step.level)));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      step.offset[axis] =
          static_cast<float>((cells_per_mm[axis] * t + 0.5)) * step.scale - 0.5f;
    }
    // Larger cells are looked at twice.
    const double cell_mm = std::ldexp(side_mm_, static_cast<int>(step.level));
    t += step.level == 0 ? cell_mm : cell_mm / 2;
  }
  return cone;
}

/// The share of light that comes to a place, in cells, through a cone.
float RayShade::passed(const std::array<float, 3>& begin, const LightCone& cone) const {
  float passed = 1;
  for (const ConeStep& step : cone) {
    std::array<float, 3> place;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      place[axis] = begin[axis] * step.scale + step.offset[axis];
    }
    const float left = 1 - levels_[step.level].at(place);
    passed *= step.level == 0 ? left : std::sqrt(std::max(left, 0.0f));
    if (passed < kNoLight) return 0;
  }
  return passed;
}

template <class Share>
void RayShade::fill(std::vector<std::uint8_t>& shares, const Progress& watcher,
                    Share&& share_of) const {
  const Size3& size = levels_.front().size;
  shares.assign(static_cast<std::size_t>(size.voxel_count()), 255);
  parallel_for(std::int64_t{0}, size.z, [&](std::int64_t z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      if (watcher.is_cancelled()) return;
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::size_t i = place_in_grid(size, x, y, z);
        if (is_lit_[i] == 0) continue;
        const float share = std::clamp(share_of(Index3{x, y, z}), 0.0f, 1.0f);
        shares[i] = static_cast<std::uint8_t>(std::lround(share * 255));
      }
    }
  });
  if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
}

/// Those with an extinction, and those around them: one axis after the other.
void RayShade::find_lit(const Size3& size, const std::vector<float>& opacities) {
  is_lit_.resize(opacities.size());
  for (std::size_t i = 0; i < is_lit_.size(); ++i) is_lit_[i] = opacities[i] > 0 ? 1 : 0;
  const std::array<std::int64_t, 3> strides{1, size.x, size.x * size.y};
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<std::uint8_t> before = is_lit_;
    std::size_t i = 0;
    visit_cells(box_of(size), {1, 1, 1}, [&](const Index3& cell) {
      const std::int64_t first = std::max<std::int64_t>(cell[axis] - kLitAround, 0);
      const std::int64_t last = std::min<std::int64_t>(cell[axis] + kLitAround, size[axis] - 1);
      for (std::int64_t at = first; at <= last; ++at) {
        const std::int64_t by = (at - cell[axis]) * strides[static_cast<std::size_t>(axis)];
        is_lit_[i] |= before[static_cast<std::size_t>(static_cast<std::int64_t>(i) + by)];
      }
      ++i;
      return true;
    });
  }
}

}  // namespace octavo
