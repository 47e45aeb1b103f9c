#include "octavo/ops/morphometry/local_thickness.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kTile = 8;        // voxels of a side of a tile
constexpr std::int64_t kTilesAWord = 64;

/// Bits [lo, hi] of a word.
std::uint64_t bits_of(std::int64_t lo, std::int64_t hi) {
  return (~std::uint64_t{0} << lo) & (~std::uint64_t{0} >> (63 - hi));
}

}  // namespace

/// One plane that balls are painted into: tiles of 8 x 8 voxels, whose bits say which are left,
/// and a bit for each tile that has any, so that what is painted costs nothing to pass over.
class LocalThickness::Plane {
 public:
  Plane(const ThicknessClass& asked, const Point3& spacing, std::int64_t z, float* mm)
      : size_(asked.mask.size()),
        tiles_across_((size_.x + kTile - 1) / kTile),
        words_((tiles_across_ + kTilesAWord - 1) / kTilesAWord),
        spacing_(spacing),
        z_(z),
        mm_(mm) {
    const std::int64_t tiles_down = (size_.y + kTile - 1) / kTile;
    tiles_.resize(static_cast<std::size_t>(tiles_across_ * tiles_down));
    has_left_.resize(static_cast<std::size_t>(words_ * tiles_down));
    const Box box = {{0, 0, z}, {size_.x, size_.y, z + 1}};
    std::vector<std::uint8_t> voxels(static_cast<std::size_t>(size_.x * size_.y));
    std::vector<std::uint8_t> region(voxels.size(), 1);
    fill_voxels(asked.mask, box, voxels.data());
    if (asked.region != nullptr) fill_voxels(*asked.region, box, region.data());
    const std::uint8_t flip = asked.is_background ? 1 : 0;
    for (std::int64_t y = 0; y < size_.y; ++y) {
      for (std::int64_t x = 0; x < size_.x; ++x) {
        const auto i = static_cast<std::size_t>(y * size_.x + x);
        const auto bit = static_cast<std::uint64_t>((voxels[i] ^ flip) & region[i]);
        tile(x / kTile, y / kTile) |= bit << (y % kTile * kTile + x % kTile);
      }
    }
    for (std::int64_t y = 0; y < tiles_down; ++y) {
      for (std::int64_t x = 0; x < tiles_across_; ++x) {
        if (tile(x, y) == 0) continue;
        has_left(x / kTilesAWord, y) |= std::uint64_t{1} << (x % kTilesAWord);
        ++tiles_left_;
      }
    }
    std::fill(mm, mm + size_.x * size_.y, 0.0F);
  }

  bool is_done() const { return tiles_left_ == 0; }

  void paint(const FittingBall& ball) {
    const double radius = ball.reach_mm * (1 - 1e-6);
    const double dz = (static_cast<double>(z_) + 0.5 - ball.center[2]) * spacing_[2];
    const double in_plane = radius * radius - dz * dz;
    if (in_plane < 0) return;
    const double reach = std::sqrt(in_plane);
    const Disc disc{ball.center[0], ball.center[1], in_plane, 2 * ball.radius_mm};
    const Span rows = span(disc.y, reach / spacing_[1], size_.y);
    const Span columns = span(disc.x, reach / spacing_[0], size_.x);
    if (rows.lo > rows.hi || columns.lo > columns.hi) return;
    const Span tiles{columns.lo / kTile, columns.hi / kTile};
    for (std::int64_t y = rows.lo / kTile; y <= rows.hi / kTile; ++y) {
      for (std::int64_t word = tiles.lo / kTilesAWord; word <= tiles.hi / kTilesAWord; ++word) {
        std::uint64_t bits = has_left(word, y);
        if (bits == 0) continue;
        const std::int64_t first = word * kTilesAWord;
        bits &= bits_of(std::max(tiles.lo - first, std::int64_t{0}),
                        std::min(tiles.hi - first, kTilesAWord - 1));
        for (; bits != 0; bits &= bits - 1) {
          paint_tile(disc, first + std::countr_zero(bits), y, rows);
        }
      }
    }
  }

  /// Gives voxels that no ball covers, which are few and near the surface, the smallest thickness
  /// of those beside them; the smallest spacing where there are none.
  void fill_left() {
    std::vector<std::pair<std::int64_t, float>> filled;
    while (tiles_left_ > 0) {
      filled.clear();
      visit_left([&](std::int64_t x, std::int64_t y) {
        float smallest = 0;
        for (std::int64_t v = std::max<std::int64_t>(y - 1, 0); v <= std::min(y + 1, size_.y - 1);
             ++v) {
          for (std::int64_t u = std::max<std::int64_t>(x - 1, 0);
               u <= std::min(x + 1, size_.x - 1); ++u) {
            const float beside = mm_[v * size_.x + u];
            if (beside > 0 && (smallest == 0 || beside < smallest)) smallest = beside;
          }
        }
        if (smallest > 0) filled.emplace_back(y * size_.x + x, smallest);
      });
      const bool is_last = filled.empty();
      if (is_last) {
        const auto thin =
            static_cast<float>(std::min({spacing_[0], spacing_[1], spacing_[2]}));
        visit_left([&](std::int64_t x, std::int64_t y) {
          filled.emplace_back(y * size_.x + x, thin);
        });
      }
      for (const auto& [i, value] : filled) {
        mm_[i] = value;
        tile(i % size_.x / kTile, i / size_.x / kTile) &=
            ~(std::uint64_t{1} << (i / size_.x % kTile * kTile + i % size_.x % kTile));
      }
      if (is_last) return;
      tiles_left_ = std::count_if(tiles_.begin(), tiles_.end(),
                                  [](std::uint64_t bits) { return bits != 0; });
    }
  }

 private:
  template <class Visit>
  void visit_left(Visit visit) {
    const auto tiles_down = static_cast<std::int64_t>(tiles_.size()) / tiles_across_;
    for (std::int64_t y = 0; y < tiles_down; ++y) {
      for (std::int64_t x = 0; x < tiles_across_; ++x) {
        for (std::uint64_t bits = tile(x, y); bits != 0; bits &= bits - 1) {
          const int bit = std::countr_zero(bits);
          visit(x * kTile + bit % kTile, y * kTile + bit / kTile);
        }
      }
    }
  }

  struct Disc {
    double x;  // of its middle, in voxels
    double y;
    double squared_mm;
    float thickness;
  };
  struct Span {
    std::int64_t lo;
    std::int64_t hi;
  };

  /// The voxels whose centers lie within so many voxels.
  static Span span(double middle, double reach, std::int64_t count) {
    const double lo = middle - 0.5 - reach;
    const double hi = middle - 0.5 + reach;
    const auto lo_below = static_cast<std::int64_t>(lo);
    const std::int64_t first = lo_below + (lo > static_cast<double>(lo_below) ? 1 : 0);
    return {lo <= 0 ? 0 : first,
            hi < 0 ? -1 : std::min(static_cast<std::int64_t>(hi), count - 1)};
  }

  std::uint64_t& tile(std::int64_t x, std::int64_t y) {
    return tiles_[static_cast<std::size_t>(y * tiles_across_ + x)];
  }
  std::uint64_t& has_left(std::int64_t word, std::int64_t y) {
    return has_left_[static_cast<std::size_t>(y * words_ + word)];
  }

  void paint_tile(const Disc& disc, std::int64_t tile_x, std::int64_t tile_y, const Span& rows) {
    std::uint64_t& left = tile(tile_x, tile_y);
    const std::int64_t begin = tile_x * kTile;
    const std::int64_t lo = std::max(rows.lo, tile_y * kTile);
    const std::int64_t hi = std::min(rows.hi, tile_y * kTile + kTile - 1);
    for (std::int64_t y = lo; y <= hi; ++y) {
      const std::int64_t shift = y % kTile * kTile;
      std::uint64_t bits = left >> shift & 255;
      if (bits == 0) continue;
      const double dy = (static_cast<double>(y) + 0.5 - disc.y) * spacing_[1];
      const double in_row = disc.squared_mm - dy * dy;
      if (in_row < 0) continue;
      const Span columns = span(disc.x, std::sqrt(in_row) / spacing_[0], size_.x);
      const std::int64_t from = std::max(columns.lo - begin, std::int64_t{0});
      const std::int64_t to = std::min(columns.hi - begin, kTile - 1);
      if (from > to) continue;
      bits &= bits_of(from, to);
      left &= ~(bits << shift);
      float* const out = mm_ + y * size_.x + begin;
      for (; bits != 0; bits &= bits - 1) out[std::countr_zero(bits)] = disc.thickness;
    }
    if (left != 0) return;
    has_left(tile_x / kTilesAWord, tile_y) &= ~(std::uint64_t{1} << (tile_x % kTilesAWord));
    --tiles_left_;
  }

  Size3 size_;
  std::int64_t tiles_across_;
  std::int64_t words_;  // of a row of tiles
  Point3 spacing_;
  std::int64_t z_;
  float* mm_;
  std::int64_t tiles_left_ = 0;
  std::vector<std::uint64_t> tiles_;
  std::vector<std::uint64_t> has_left_;
};

double ThicknessSummary::quantile_mm(double share) const {
  const double wanted = share * static_cast<double>(voxels);
  double below = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const auto here = static_cast<double>(bins[i]);
    if (below + here >= wanted && here > 0) {
      const double mm = bin_mm * (static_cast<double>(i) + (wanted - below) / here);
      return std::clamp(mm, minimum_mm, maximum_mm);
    }
    below += here;
  }
  return 0;
}

LocalThickness::LocalThickness(const ThicknessClass& asked, const Point3& spacing_mm,
                               const std::vector<FittingBall>& balls)
    : asked_(asked), spacing_(spacing_mm), balls_(balls) {}

void LocalThickness::read(std::int64_t begin, std::int64_t end, float* mm) const {
  const double lo_mm = (static_cast<double>(begin) + 0.5) * spacing_[2];
  const double hi_mm = (static_cast<double>(end) - 0.5) * spacing_[2];
  std::vector<std::uint32_t> near;
  for (std::size_t i = 0; i < balls_.size(); ++i) {
    const double z_mm = spacing_[2] * balls_[i].center[2];
    const double reach = balls_[i].reach_mm;
    if (z_mm + reach < lo_mm || z_mm - reach > hi_mm) continue;
    near.push_back(static_cast<std::uint32_t>(i));
  }
  const std::int64_t plane = asked_.mask.size().x * asked_.mask.size().y;
  parallel_for(begin, end, [&](std::int64_t z) {
    Plane painted(asked_, spacing_, z, mm + (z - begin) * plane);
    for (const std::uint32_t i : near) {
      if (painted.is_done()) break;
      painted.paint(balls_[i]);
    }
    painted.fill_left();
  });
}

void LocalThickness::add(const float* mm, std::int64_t count, ThicknessSummary& summary) const {
  if (summary.bin_mm == 0) {
    summary.bin_mm = 0.1 * std::min({spacing_[0], spacing_[1], spacing_[2]});
  }
  for (std::int64_t i = 0; i < count; ++i) {
    const double value = mm[i];
    if (value <= 0) continue;
    const bool is_first = summary.voxels == 0;
    summary.minimum_mm = is_first ? value : std::min(summary.minimum_mm, value);
    summary.maximum_mm = std::max(summary.maximum_mm, value);
    ++summary.voxels;
    summary.mean_mm += value;
    summary.deviation_mm += value * value;
    const auto bin = static_cast<std::size_t>(value / summary.bin_mm);
    if (bin >= summary.bins.size()) summary.bins.resize(bin + 1);
    ++summary.bins[bin];
  }
}

void LocalThickness::finish(ThicknessSummary& summary) {
  if (summary.voxels == 0) return;
  const auto count = static_cast<double>(summary.voxels);
  const double mean = summary.mean_mm / count;
  summary.deviation_mm = std::sqrt(std::max(0.0, summary.deviation_mm / count - mean * mean));
  summary.mean_mm = mean;
}

}  // namespace octavo
