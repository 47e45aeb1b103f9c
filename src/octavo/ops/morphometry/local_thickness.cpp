#include "octavo/ops/morphometry/local_thickness.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <bit>
#include <cmath>

namespace octavo {

/// One plane that balls are painted into.
class LocalThickness::Plane {
 public:
  Plane(const ThicknessClass& asked, const Point3& spacing, std::int64_t z, float* mm)
      : size_(asked.mask.size()),
        words_((size_.x + 63) / 64),
        spacing_(spacing),
        z_(z),
        mm_(mm),
        left_(static_cast<std::size_t>(words_ * size_.y)) {
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
        left_[static_cast<std::size_t>(y * words_ + x / 64)] |= bit << (x & 63);
      }
    }
    std::fill(mm, mm + size_.x * size_.y, 0.0F);
  }

  void paint(const FittingBall& ball) {
    const double radius = ball.reach_mm * (1 - 1e-6);
    const double dz = static_cast<double>(2 * z_ + 1 - ball.half_index[2]) * 0.5 * spacing_[2];
    const double in_plane = radius * radius - dz * dz;
    if (in_plane < 0) return;
    const double half_rows = std::sqrt(in_plane) / (0.5 * spacing_[1]);
    const std::int64_t y_lo = first(ball.half_index[1], half_rows);
    const std::int64_t y_hi = last(ball.half_index[1], half_rows, size_.y);
    const double widest = std::sqrt(in_plane) / (0.5 * spacing_[0]);
    const std::int64_t word_lo = first(ball.half_index[0], widest) / 64;
    const std::int64_t word_hi = last(ball.half_index[0], widest, size_.x) / 64;
    for (std::int64_t y = y_lo; y <= y_hi; ++y) {
      if (is_painted(y, word_lo, word_hi)) continue;
      const double dy = static_cast<double>(2 * y + 1 - ball.half_index[1]) * 0.5 * spacing_[1];
      const double in_row = in_plane - dy * dy;
      if (in_row < 0) continue;
      const double half_columns = std::sqrt(in_row) / (0.5 * spacing_[0]);
      const std::int64_t lo = first(ball.half_index[0], half_columns);
      const std::int64_t hi = last(ball.half_index[0], half_columns, size_.x);
      if (lo <= hi) paint_row(y, lo, hi, 2 * ball.radius_mm);
    }
  }

 private:
  /// The voxels whose centers lie within so many half voxels.
  static std::int64_t first(std::int32_t half_index, double reach) {
    const double lo = std::ceil(0.5 * (half_index - 1 - reach));
    return std::max<std::int64_t>(static_cast<std::int64_t>(lo), 0);
  }
  static std::int64_t last(std::int32_t half_index, double reach, std::int64_t count) {
    const double hi = std::floor(0.5 * (half_index - 1 + reach));
    return std::min<std::int64_t>(static_cast<std::int64_t>(hi), count - 1);
  }

  /// Whether nothing is left in words of a row.
  bool is_painted(std::int64_t y, std::int64_t lo, std::int64_t hi) const {
    std::uint64_t any = 0;
    for (std::int64_t word = lo; word <= hi; ++word) {
      any |= left_[static_cast<std::size_t>(y * words_ + word)];
    }
    return any == 0;
  }

  void paint_row(std::int64_t y, std::int64_t lo, std::int64_t hi, float thickness) {
    std::uint64_t* const row = left_.data() + y * words_;
    float* const out = mm_ + y * size_.x;
    for (std::int64_t word = lo / 64; word <= hi / 64; ++word) {
      std::uint64_t bits = row[word];
      if (bits == 0) continue;
      if (word == lo / 64) bits &= ~std::uint64_t{0} << (lo & 63);
      if (word == hi / 64) bits &= ~std::uint64_t{0} >> (63 - (hi & 63));
      row[word] &= ~bits;
      for (; bits != 0; bits &= bits - 1) out[64 * word + std::countr_zero(bits)] = thickness;
    }
  }

  Size3 size_;
  std::int64_t words_;  // of a row
  Point3 spacing_;
  std::int64_t z_;
  float* mm_;
  std::vector<std::uint64_t> left_;
};

double ThicknessSummary::quantile_mm(double share) const {
  const double wanted = share * static_cast<double>(voxels);
  double below = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    const auto here = static_cast<double>(bins[i]);
    if (below + here >= wanted && here > 0) {
      return bin_mm * (static_cast<double>(i) + (wanted - below) / here);
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
    const double z_mm = 0.5 * spacing_[2] * balls_[i].half_index[2];
    const double reach = balls_[i].reach_mm;
    if (z_mm + reach < lo_mm || z_mm - reach > hi_mm) continue;
    near.push_back(static_cast<std::uint32_t>(i));
  }
  const std::int64_t plane = asked_.mask.size().x * asked_.mask.size().y;
  tbb::parallel_for(begin, end, [&](std::int64_t z) {
    Plane painted(asked_, spacing_, z, mm + (z - begin) * plane);
    for (const std::uint32_t i : near) painted.paint(balls_[i]);
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
