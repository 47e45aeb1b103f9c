#include "octavo/ops/distance/site_shares.h"

#include <algorithm>
#include <cmath>

namespace octavo {

namespace {

constexpr std::int64_t kShareReach = 2;
constexpr std::array<std::uint32_t, 3> kShareWeights = {128, 58, 6};
constexpr double kShareSum = 256.0 * 256.0 * 256.0;

/// Bytes of planes around those that are asked for.
class SharePlanes {
 public:
  SharePlanes(const InsideVoxels& voxels, std::int64_t begin, std::int64_t end)
      : size_(voxels.size),
        lo_(std::max<std::int64_t>(begin - kShareReach, 0)),
        hi_(std::min(end + kShareReach, voxels.size.z)),
        inside_(static_cast<std::size_t>((hi_ - lo_) * size_.x * size_.y)) {
    voxels.fill({{0, 0, lo_}, {size_.x, size_.y, hi_}}, inside_.data());
  }

  const std::uint8_t* plane(std::int64_t z) const {
    const std::int64_t held = std::clamp(z, lo_, hi_ - 1) - lo_;
    return inside_.data() + held * size_.x * size_.y;
  }
  const std::uint8_t* row(std::int64_t y, std::int64_t z) const {
    return plane(z) + std::clamp<std::int64_t>(y, 0, size_.y - 1) * size_.x;
  }
  std::uint8_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return row(y, z)[std::clamp<std::int64_t>(x, 0, size_.x - 1)];
  }
  const Size3& size() const { return size_; }

  /// Whether the surface is flat beside a voxel: one of its faces lies between a layer of its class
  /// and one of the other class, which may end at a cliff, on one side of the voxel.
  ///
  ///     .  .  .  .  .        the voxel is the one above the face
  ///     o  o  o  .  .   <    a layer that ends; what is one voxel high is a step of a surface that
  ///     o  o  o  .  .        lies aslant, and so is a cliff down here and one up on the other side
  bool is_flat(const Index3& p) const {
    const std::uint8_t own = at(p.x, p.y, p.z);
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      const std::int64_t step = side % 2 == 0 ? -1 : 1;
      Index3 q = p;
      q[axis] += step;
      if (at(q.x, q.y, q.z) != own && is_flat_towards(p, own, axis, step)) return true;
    }
    return false;
  }

 private:
  /// Whether the face of a voxel of a class on one side of an axis is one of a flat surface.
  bool is_flat_towards(const Index3& p, std::uint8_t own, int axis, std::int64_t step) const {
    const auto is_own = [&](int column, std::int64_t up) {
      Index3 q = p;
      q[(axis + 1) % 3] += column % 3 - 1;
      q[(axis + 2) % 3] += column / 3 - 1;
      q[axis] += up * step;
      return at(q.x, q.y, q.z) == own;
    };
    bool has_cliff_down = false;
    bool has_cliff_up = false;
    for (const int column : {1, 3, 5, 7, 0, 2, 6, 8}) {
      const bool here = is_own(column, 0);
      const bool beyond = is_own(column, 1);
      if (here && !beyond) continue;
      if (here != beyond || is_own(column, here ? 2 : -1) != here) return false;
      (here ? has_cliff_down : has_cliff_up) = true;
    }
    return !has_cliff_down || !has_cliff_up;
  }

  Size3 size_;
  std::int64_t lo_;
  std::int64_t hi_;
  std::vector<std::uint8_t> inside_;
};

/// A row and those around it.
class RowsBeside {
 public:
  RowsBeside(const SharePlanes& planes, std::int64_t y, std::int64_t z)
      : last_(planes.size().x - 1),
        row_(planes.row(y, z)),
        around_{planes.row(y - 1, z), planes.row(y + 1, z), planes.row(y, z - 1),
                planes.row(y, z + 1)} {}

  /// Whether a voxel of the other class shares a face with one of the row.
  bool has_other(std::int64_t x) const {
    const std::uint8_t own = row_[x];
    int differ = own ^ row_[std::max<std::int64_t>(x - 1, 0)];
    differ |= own ^ row_[std::min(x + 1, last_)];
    for (const std::uint8_t* const one : around_) differ |= own ^ one[x];
    return differ != 0;
  }

 private:
  std::int64_t last_;
  const std::uint8_t* row_;
  std::array<const std::uint8_t*, 4> around_;
};

/// The weighted sum of five rows.
template <class In>
void mix_rows(const std::array<const In*, 5>& rows, std::int64_t count, std::uint32_t* mixed) {
  for (std::int64_t i = 0; i < count; ++i) {
    mixed[i] = kShareWeights[0] * rows[2][i] + kShareWeights[1] * (rows[1][i] + rows[3][i]) +
               kShareWeights[2] * (rows[0][i] + rows[4][i]);
  }
}

}  // namespace

void fill_shares(const InsideVoxels& voxels, std::int64_t begin, std::int64_t end,
                 NearestSite* sites) {
  const Size3 size = voxels.size;
  const std::int64_t plane = size.x * size.y;
  const SharePlanes planes(voxels, begin, end);
  std::vector<std::uint32_t> through_z(static_cast<std::size_t>(plane));
  std::vector<std::uint32_t> row(static_cast<std::size_t>(size.x + 2 * kShareReach));
  std::vector<std::uint32_t> sums(static_cast<std::size_t>(size.x));
  for (std::int64_t z = begin; z < end; ++z) {
    mix_rows<std::uint8_t>({planes.plane(z - 2), planes.plane(z - 1), planes.plane(z),
                            planes.plane(z + 1), planes.plane(z + 2)},
                           plane, through_z.data());
    const std::uint8_t* const own = planes.plane(z);
    const auto row_at = [&](std::int64_t y) {
      return through_z.data() + std::clamp<std::int64_t>(y, 0, size.y - 1) * size.x;
    };
    for (std::int64_t y = 0; y < size.y; ++y) {
      std::uint32_t* const middle = row.data() + kShareReach;
      mix_rows<std::uint32_t>({row_at(y - 2), row_at(y - 1), row_at(y), row_at(y + 1),
                               row_at(y + 2)},
                              size.x, middle);
      for (std::int64_t i = 1; i <= kShareReach; ++i) {
        middle[-i] = middle[0];
        middle[size.x - 1 + i] = middle[size.x - 1];
      }
      const std::uint32_t* const r = row.data();
      mix_rows<std::uint32_t>({r, r + 1, r + 2, r + 3, r + 4}, size.x, sums.data());
      const RowsBeside beside(planes, y, z);
      NearestSite* const out = sites + (z - begin) * plane + y * size.x;
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::uint8_t is_inside = own[y * size.x + x];
        const double share = sums[static_cast<std::size_t>(x)] / kShareSum;
        const double other = is_inside != 0 ? 1 - share : share;
        auto steps = static_cast<std::uint8_t>(std::min(other, 0.75) * kSharesOfAll);
        // Between one voxel beside this one and all around it.
        if (other > 0.05 && other < 0.9 && beside.has_other(x) && planes.is_flat({x, y, z})) {
          steps = kFlatShare;
        }
        out[x].own = static_cast<std::uint8_t>(steps << 1 | is_inside);
      }
    }
  }
}

double surface_gap(std::uint8_t share) {
  // Half a space, smeared by a normal distribution as wide as the weights are. The line below is
  // what places of random planes are to that.
  constexpr double kWidth = 0.8;
  static const std::array<float, 128> gaps = [] {
    std::array<float, 128> made{};
    for (std::size_t i = 0; i < made.size(); ++i) {
      const double wanted = (static_cast<double>(i) + 0.5) / kSharesOfAll;
      double lo = -4;
      double hi = 4;
      for (int k = 0; k < 40; ++k) {
        const double middle = 0.5 * (lo + hi);
        (0.5 * std::erfc(middle / (kWidth * std::sqrt(2.0))) > wanted ? lo : hi) = middle;
      }
      made[i] = static_cast<float>(std::clamp(1.03 * lo - 0.042, -0.87, 0.87));
    }
    made[kFlatShare] = 0.5F;
    return made;
  }();
  return static_cast<double>(gaps[share]);
}

}  // namespace octavo
