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
  std::uint8_t at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    return plane(z)[std::clamp<std::int64_t>(y, 0, size_.y - 1) * size_.x +
                    std::clamp<std::int64_t>(x, 0, size_.x - 1)];
  }

  /// Whether the surface is flat beside a voxel: a layer of 3 x 3 voxels of its class around it,
  /// and one of the other class beside that.
  bool is_flat(const Index3& p) const {
    const std::uint8_t own = at(p.x, p.y, p.z);
    for (int side = 0; side < 6; ++side) {
      const int axis = side / 2;
      const std::int64_t step = side % 2 == 0 ? -1 : 1;
      bool is_layer = true;
      for (int i = 0; i < 9 && is_layer; ++i) {
        Index3 q = p;
        q[(axis + 1) % 3] += i % 3 - 1;
        q[(axis + 2) % 3] += i / 3 - 1;
        is_layer = at(q.x, q.y, q.z) == own;
        q[axis] += step;
        is_layer = is_layer && at(q.x, q.y, q.z) != own;
      }
      if (is_layer) return true;
    }
    return false;
  }

 private:
  Size3 size_;
  std::int64_t lo_;
  std::int64_t hi_;
  std::vector<std::uint8_t> inside_;
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
      NearestSite* const out = sites + (z - begin) * plane + y * size.x;
      for (std::int64_t x = 0; x < size.x; ++x) {
        const std::uint8_t is_inside = own[y * size.x + x];
        const double share = sums[static_cast<std::size_t>(x)] / kShareSum;
        const double other = is_inside != 0 ? 1 - share : share;
        auto steps = static_cast<std::uint8_t>(std::min(other, 0.75) * kSharesOfAll);
        // Between a plate of one voxel and half a space.
        if (other > 0.22 && other < 0.26 && planes.is_flat({x, y, z})) steps = kFlatShare;
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
