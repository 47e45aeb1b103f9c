#include "octavo/ops/distance/distance_field.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "octavo/ops/distance/scratch_planes.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr std::int64_t kFloatBytes = 4;

/// The largest square, whatever its sign.
float largest_of(const float* squared, std::int64_t count) {
  return parallel_reduce(
      std::int64_t{0}, count, 1 << 16, 0.0F,
      [&](std::int64_t begin, std::int64_t end, float largest) {
        for (std::int64_t i = begin; i != end; ++i) {
          largest = std::max(largest, std::abs(squared[i]));
        }
        return largest;
      },
      [](float a, float b) { return std::max(a, b); });
}

double length_mm(float squared, const DistanceSettings& settings, double limit_mm) {
  const double root = std::sqrt(static_cast<double>(squared));
  return std::min(root * distance_unit_mm(settings), limit_mm);
}

class FieldInMemory final : public DistanceField {
 public:
  FieldInMemory(const InsideVoxels& voxels, const DistanceSettings& settings, double limit_mm,
                Progress& progress)
      : plane_(voxels.size.x * voxels.size.y),
        settings_(settings),
        limit_mm_(limit_mm),
        squared_(static_cast<std::size_t>(voxels.size.voxel_count())) {
    measure_planes(voxels, 0, voxels.size.z, settings, progress, squared_.data());
    measure_columns(voxels.size, settings, squared_.data());
    largest_mm_ = length_mm(largest_of(squared_.data(), voxels.size.voxel_count()), settings,
                            limit_mm);
  }

  void read(std::int64_t begin, std::int64_t end, float* mm) override {
    to_distances((end - begin) * plane_, settings_, limit_mm_, squared_.data() + begin * plane_,
                 mm);
  }
  std::optional<double> largest_mm() const override { return largest_mm_; }

 private:
  std::int64_t plane_;
  DistanceSettings settings_;
  double limit_mm_;
  std::vector<float> squared_;
  double largest_mm_ = 0;
};

class FieldOnDisk final : public DistanceField {
 public:
  FieldOnDisk(const InsideVoxels& voxels, const DistanceSettings& settings, double limit_mm,
              std::uint64_t bytes, Storage& storage, const std::string& folder,
              Progress& progress)
      : plane_(voxels.size.x * voxels.size.y),
        settings_(settings),
        limit_mm_(limit_mm),
        planes_(voxels.size, storage, folder) {
    std::vector<float> room(static_cast<std::size_t>(bytes) / kFloatBytes);
    planes_.write_planes(room, [&](std::int64_t begin, std::int64_t end, float* squared) {
      measure_planes(voxels, begin, end, settings, progress, squared);
    });
    float largest = 0;
    planes_.change_rows(room, progress, [&](const Size3& block, float* squared) {
      measure_columns(block, settings, squared);
      largest = std::max(largest, largest_of(squared, block.voxel_count()));
    });
    largest_mm_ = length_mm(largest, settings, limit_mm);
  }

  void read(std::int64_t begin, std::int64_t end, float* mm) override {
    planes_.read(begin, end, mm);
    to_distances((end - begin) * plane_, settings_, limit_mm_, mm, mm);
  }
  std::optional<double> largest_mm() const override { return largest_mm_; }

 private:
  std::int64_t plane_;
  DistanceSettings settings_;
  double limit_mm_;
  ScratchPlanes<float> planes_;
  double largest_mm_ = 0;
};

class FieldInWindow final : public DistanceField {
 public:
  FieldInWindow(const InsideVoxels& voxels, const DistanceSettings& settings, double limit_mm,
                std::int64_t halo, Progress& progress)
      : voxels_(voxels),
        settings_(settings),
        limit_mm_(limit_mm),
        halo_(halo),
        progress_(progress) {}

  void read(std::int64_t begin, std::int64_t end, float* mm) override {
    const std::int64_t plane = voxels_.size.x * voxels_.size.y;
    const std::int64_t lo = std::max<std::int64_t>(begin - halo_, 0);
    const std::int64_t hi = std::min(end + halo_, voxels_.size.z);
    const auto planes_at = [&](std::int64_t z) { return (z - lo) * plane; };
    std::vector<float> in_planes(static_cast<std::size_t>((hi - lo) * plane));

    // Planes of the window before are kept where they are needed again.
    const std::int64_t kept_lo = std::max(lo, lo_);
    const std::int64_t kept_hi = std::max(kept_lo, std::min(hi, hi_));
    if (kept_lo < kept_hi) {
      std::memcpy(in_planes.data() + planes_at(kept_lo),
                  in_planes_.data() + (kept_lo - lo_) * plane,
                  static_cast<std::size_t>((kept_hi - kept_lo) * plane * kFloatBytes));
      measure_planes(voxels_, lo, kept_lo, settings_, progress_, in_planes.data());
      measure_planes(voxels_, kept_hi, hi, settings_, progress_,
                     in_planes.data() + planes_at(kept_hi));
    } else {
      measure_planes(voxels_, lo, hi, settings_, progress_, in_planes.data());
    }
    in_planes_ = std::move(in_planes);
    lo_ = lo;
    hi_ = hi;

    std::vector<float> squared = in_planes_;
    measure_columns({voxels_.size.x, voxels_.size.y, hi - lo}, settings_, squared.data());
    to_distances((end - begin) * plane, settings_, limit_mm_, squared.data() + planes_at(begin),
                 mm);
  }
  std::optional<double> largest_mm() const override { return std::nullopt; }

 private:
  InsideVoxels voxels_;
  DistanceSettings settings_;
  double limit_mm_;
  std::int64_t halo_;
  Progress& progress_;
  std::vector<float> in_planes_;  // squared distances within planes lo_ .. hi_
  std::int64_t lo_ = 0;
  std::int64_t hi_ = 0;
};

}  // namespace

FieldPlan plan_distance_field(const Size3& size, const DistanceSettings& settings, double limit_mm,
                              std::uint64_t max_bytes) {
  const auto plane = static_cast<std::uint64_t>(size.x * size.y * kFloatBytes);
  const std::uint64_t all = plane * static_cast<std::uint64_t>(size.z);
  FieldPlan plan;
  plan.slab = std::min<std::int64_t>(64, size.z);
  plan.bytes = all;
  if (all <= max_bytes) return plan;

  // A window of two copies, where a limit makes it smaller than the rows of the pass along z.
  const double halo = std::min(limit_mm / settings.spacing_mm[2], 1e9);
  plan.halo = static_cast<std::int64_t>(std::ceil(halo)) + 1;
  const std::uint64_t window = 2 * plane * static_cast<std::uint64_t>(plan.slab + 2 * plan.halo);
  if (window <= std::max(max_bytes, all / 2)) {
    plan.hold = DistanceHold::window;
    plan.bytes = window;
    return plan;
  }
  plan.hold = DistanceHold::disk;
  plan.halo = 0;
  const auto row = static_cast<std::uint64_t>(size.x * size.z * kFloatBytes);
  plan.bytes = std::max({max_bytes, plane, row});
  return plan;
}

std::unique_ptr<DistanceField> make_distance_field(const InsideVoxels& voxels,
                                                   const DistanceSettings& settings,
                                                   double limit_mm, const FieldPlan& plan,
                                                   Storage& storage, const std::string& folder,
                                                   Progress& progress) {
  switch (plan.hold) {
    case DistanceHold::memory:
      return std::make_unique<FieldInMemory>(voxels, settings, limit_mm, progress);
    case DistanceHold::disk:
      return std::make_unique<FieldOnDisk>(voxels, settings, limit_mm, plan.bytes, storage, folder,
                                           progress);
    case DistanceHold::window: break;
  }
  return std::make_unique<FieldInWindow>(voxels, settings, limit_mm, plan.halo, progress);
}

}  // namespace octavo
