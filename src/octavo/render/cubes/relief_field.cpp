#include "octavo/render/cubes/relief_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <tuple>
#include <utility>

namespace octavo {

namespace {

class MaskRelief final : public ReliefField {
 public:
  explicit MaskRelief(std::span<const MaskTree* const> masks)
      : masks_(masks.begin(), masks.end()) {}

  std::size_t field_of(std::size_t) const override { return 0; }

  void read(std::size_t, const Box& box, float* values) const override {
    std::fill_n(values, box.size().voxel_count(), 0.0F);
    for (const MaskTree* const mask : masks_) {
      visit_items(*mask, box, [&](int rank, std::uint64_t place, const Index3& corner) {
        const std::uint64_t full = rank < 0 ? mask->words()[place] : mask->cubes(rank)[place].full;
        fill_children(full, rank, corner, box, 1.0F, values);
      });
    }
  }

  // Wide enough that the steps of a slanted surface vanish.
  double smoothing() const override { return 1.8; }
  bool is_cut_at_border() const override { return false; }

 private:
  std::vector<const MaskTree*> masks_;
};

class GreyRelief final : public ReliefField {
 public:
  GreyRelief(const FileReader& reader, int level, std::vector<ReliefRange> ranges)
      : reader_(reader), level_(level), ranges_(std::move(ranges)) {
    const VolumeDescription& d = reader.description();
    std::tie(low_, high_) = std::minmax({d.voxel_of(d.code_near(reader.range().min)),
                                         d.voxel_of(d.code_near(reader.range().max))});
  }

  std::size_t field_of(std::size_t mask) const override { return mask; }

  void read(std::size_t field, const Box& box, float* values) const override {
    const Box inside = intersection(box, box_of(reader_.levels().size(level_)));
    const Size3 held = inside.size();
    const VoxelType type = reader_.description().type;
    std::vector<std::byte> bytes(static_cast<std::size_t>(held.voxel_count()) *
                                 static_cast<std::size_t>(bytes_per_voxel(type)));
    reader_.read(inside, level_, bytes.data());
    with_voxel_type(
        type, [&](auto tag) { spread<typename decltype(tag)::type>(bytes, inside, box, values); });
    const ReliefRange& range = ranges_[field];
    const auto depth_of = [&](double value) {
      return std::min(value - range.lowest, range.highest - value);
    };
    // No mask holds what is no number: it lies as far outside as values reach inside.
    const double outside = -std::max(std::abs(depth_of(low_)), std::abs(depth_of(high_)));
    for (float* value = values; value != values + box.size().voxel_count(); ++value) {
      const double number = static_cast<double>(*value);
      *value = static_cast<float>(
          std::isnan(number) ? outside : depth_of(std::clamp(number, low_, high_)));
    }
  }

  // The values vary smoothly by themselves; what is taken away is noise.
  double smoothing() const override { return 1.0; }
  bool is_cut_at_border() const override { return true; }

 private:
  template <class T>
  static void spread(const std::vector<std::byte>& bytes, const Box& inside, const Box& box,
                     float* values) {
    const Size3 held = inside.size();
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      const std::int64_t from_z = std::clamp(z, inside.lo.z, inside.hi.z - 1) - inside.lo.z;
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const std::int64_t from_y = std::clamp(y, inside.lo.y, inside.hi.y - 1) - inside.lo.y;
        const std::int64_t row = (from_z * held.y + from_y) * held.x;
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          const std::int64_t from_x = std::clamp(x, inside.lo.x, inside.hi.x - 1) - inside.lo.x;
          T value;
          std::memcpy(&value, bytes.data() + static_cast<std::size_t>(row + from_x) * sizeof value,
                      sizeof value);
          *values++ = static_cast<float>(value);
        }
      }
    }
  }

  const FileReader& reader_;
  int level_;
  std::vector<ReliefRange> ranges_;
  double low_ = 0;  // of the finite values of the file
  double high_ = 0;
};

/// The weights of a Gaussian for offsets 0 .. reach; with both sides they add up to 1.
std::vector<float> gaussian(double deviation) {
  const auto reach = static_cast<int>(std::ceil(2.5 * deviation));
  std::vector<double> weights;
  double sum = 0;
  for (int i = 0; i <= reach; ++i) {
    weights.push_back(std::exp(-i * i / (2 * deviation * deviation)));
    sum += (i == 0 ? 1 : 2) * weights.back();
  }
  std::vector<float> result;
  for (const double weight : weights) result.push_back(static_cast<float>(weight / sum));
  return result;
}

/// Smooths `lines` x `run` x `stride` numbers along the middle axis, whose ends are cropped.
std::vector<float> smoothed_along(const std::vector<float>& values, std::int64_t lines,
                                  std::int64_t run, std::int64_t stride,
                                  const std::vector<float>& weights) {
  const auto reach = static_cast<std::int64_t>(weights.size()) - 1;
  const std::int64_t kept = run - 2 * reach;
  std::vector<float> result(static_cast<std::size_t>(lines * kept * stride));
  for (std::int64_t line = 0; line < lines; ++line) {
    for (std::int64_t i = 0; i < kept; ++i) {
      const float* const from = values.data() + (line * run + i + reach) * stride;
      float* const to = result.data() + (line * kept + i) * stride;
      for (std::int64_t s = 0; s < stride; ++s) to[s] = weights[0] * from[s];
      for (std::int64_t k = 1; k <= reach; ++k) {
        const float weight = weights[static_cast<std::size_t>(k)];
        const float* const before = from - k * stride;
        const float* const behind = from + k * stride;
        for (std::int64_t s = 0; s < stride; ++s) to[s] += weight * (before[s] + behind[s]);
      }
    }
  }
  return result;
}

}  // namespace

std::unique_ptr<ReliefField> mask_relief(std::span<const MaskTree* const> masks) {
  return std::make_unique<MaskRelief>(masks);
}

std::unique_ptr<ReliefField> grey_relief(const FileReader& reader, int level,
                                         std::vector<ReliefRange> ranges) {
  return std::make_unique<GreyRelief>(reader, level, std::move(ranges));
}

std::vector<float> smoothed(const ReliefField& relief, std::size_t field, const Box& box) {
  const std::vector<float> weights = gaussian(relief.smoothing());
  const auto reach = static_cast<std::int64_t>(weights.size()) - 1;
  Box wide = box;
  for (int axis = 0; axis < 3; ++axis) {
    wide.lo[axis] -= reach;
    wide.hi[axis] += reach;
  }
  const Size3 all = wide.size();
  const Size3 kept = box.size();
  std::vector<float> values(static_cast<std::size_t>(all.voxel_count()));
  relief.read(field, wide, values.data());
  values = smoothed_along(values, all.z * all.y, all.x, 1, weights);
  values = smoothed_along(values, all.z, all.y, kept.x, weights);
  return smoothed_along(values, 1, all.z, kept.y * kept.x, weights);
}

}  // namespace octavo
