#include "octavo/planes/between/shape_between.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/planes/between/site_distance.h"

namespace octavo {

namespace {

constexpr std::uint64_t kDecisionBytes = std::uint64_t{64} << 20;
constexpr std::size_t kMostWays = 16;
/// Of a pixel besides its decisions: masks, rows of sites, places, distances.
constexpr std::uint64_t kWorkBytes = 40;
constexpr float kNowhere = std::numeric_limits<float>::infinity();

/// Borders lie half way between pixels.
float border_distance(std::int64_t squared) {
  return static_cast<float>(std::sqrt(static_cast<double>(squared)) - 0.5);
}

/// How far the pixels of a plane lie inside the label they have.
template <class T>
class InsideDistance {
 public:
  InsideDistance(std::size_t columns, std::size_t rows)
      : columns_(columns), rows_(rows), other_row_(columns * rows), below_(columns) {}

  /// Finds in every column the nearest pixel with another label.
  void take(std::span<const T> plane) {
    plane_ = plane;
    for (std::size_t y = 0; y < rows_; ++y) {
      for (std::size_t x = 0; x < columns_; ++x) {
        const std::size_t i = y * columns_ + x;
        other_row_[i] = y == 0 ? -1
                        : plane[i - columns_] != plane[i] ? static_cast<std::int32_t>(y) - 1
                                                          : other_row_[i - columns_];
      }
    }
    std::fill(below_.begin(), below_.end(), -1);
    for (std::size_t y = rows_ - 1; y-- > 0;) {
      for (std::size_t x = 0; x < columns_; ++x) {
        const std::size_t i = y * columns_ + x;
        const auto here = static_cast<std::int32_t>(y);
        if (plane[i + columns_] != plane[i]) below_[x] = here + 1;
        if (below_[x] < 0) continue;
        if (other_row_[i] < 0 || below_[x] - here < here - other_row_[i]) other_row_[i] = below_[x];
      }
    }
  }

  /// Distances of the pixels of the run with one label that holds `index`, from its first on; the
  /// run is [first, last) in the plane. kNowhere where the plane has no other label.
  std::span<const float> measure_run(std::size_t index, std::size_t& first, std::size_t& last) {
    const std::size_t row = index / columns_ * columns_;
    first = last = index;
    while (first > row && plane_[first - 1] == plane_[index]) --first;
    while (last < row + columns_ && plane_[last] == plane_[index]) ++last;
    const auto y = static_cast<std::int64_t>(index / columns_);
    heights_.clear();
    heights_.push_back(first > row ? 0 : kNoSite);
    for (std::size_t i = first; i < last; ++i) {
      const std::int64_t away = other_row_[i] - y;
      heights_.push_back(other_row_[i] < 0 ? kNoSite : away * away);
    }
    heights_.push_back(last < row + columns_ ? 0 : kNoSite);
    nearest_.resize(heights_.size());
    distances_.assign(last - first, kNowhere);
    if (!envelope_.find(heights_, nearest_)) return distances_;
    for (std::size_t k = 0; k < distances_.size(); ++k) {
      const std::int64_t aside = static_cast<std::int64_t>(k) + 1 - nearest_[k + 1];
      distances_[k] =
          border_distance(aside * aside + heights_[static_cast<std::size_t>(nearest_[k + 1])]);
    }
    return distances_;
  }

 private:
  std::size_t columns_;
  std::size_t rows_;
  std::span<const T> plane_;
  std::vector<std::int32_t> other_row_;  ///< -1: none in this column
  std::vector<std::int32_t> below_;
  RowEnvelope envelope_;
  std::vector<std::int64_t> heights_;
  std::vector<std::int32_t> nearest_;
  std::vector<float> distances_;
};

template <class T>
class ShapesOf final : public ShapeBetween {
 public:
  ShapesOf(std::int64_t columns, std::int64_t rows)
      : columns_(static_cast<std::size_t>(columns)),
        rows_(static_cast<std::size_t>(rows)),
        inside_(columns_, rows_),
        sites_(columns, rows),
        mask_(columns_ * rows_),
        row_(columns_) {}

  std::size_t max_ways() const override {
    const std::size_t count = std::max<std::size_t>(1, places_.size());
    return std::clamp<std::uint64_t>(kDecisionBytes / ((sizeof(float) + sizeof(T)) * count), 1,
                                     kMostWays);
  }

  void set_pair(std::span<const std::byte> below, std::span<const std::byte> above) override {
    take(below, below_);
    take(above, above_);
    places_.clear();
    labels_.clear();
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      if (below_.voxels[i] == above_.voxels[i]) continue;
      places_.push_back(i);
      note_label(below_.voxels[i]);
      note_label(above_.voxels[i]);
    }
    sort_labels();
    for (Plane* plane : {&below_, &above_}) find_insides(*plane);
    limit_insides();
  }

  void decide(std::span<const WayUp> ways) override {
    ways_.assign(ways.begin(), ways.end());
    scores_.assign(ways_.size() * places_.size(), -kNowhere);
    winners_.assign(ways_.size() * places_.size(), T{});
    if (places_.empty()) return;
    for (const T label : labels_) {
      measure(label);
      for (std::size_t p = 0; p < places_.size(); ++p) {
        propose(p, label, below_.distance[p], above_.distance[p]);
      }
    }
    propose_unchanged();
  }

  void fill(std::size_t index, std::span<std::byte> plane) const override {
    std::memcpy(plane.data(), below_.voxels.data(), plane.size());
    for (std::size_t p = 0; p < places_.size(); ++p) {
      const T label = winners_[index * places_.size() + p];
      std::memcpy(plane.data() + places_[p] * sizeof(T), &label, sizeof(T));
    }
  }

 private:
  struct Plane {
    std::vector<T> voxels;
    std::vector<float> inside;    ///< of the label that a place has
    std::vector<float> distance;  ///< signed, of the label that is measured
  };

  void take(std::span<const std::byte> bytes, Plane& plane) {
    plane.voxels.resize(mask_.size());
    std::memcpy(plane.voxels.data(), bytes.data(), mask_.size() * sizeof(T));
  }

  /// Neighbors mostly have the same label: few come twice.
  void note_label(T label) {
    const std::size_t count = labels_.size();
    if (count > 0 && labels_[count - 1] == label) return;
    if (count > 1 && labels_[count - 2] == label) return;
    labels_.push_back(label);
    if (labels_.size() < note_limit_) return;
    sort_labels();
    note_limit_ = std::max(note_limit_, 2 * labels_.size());
  }

  void sort_labels() {
    std::sort(labels_.begin(), labels_.end());
    labels_.erase(std::unique(labels_.begin(), labels_.end()), labels_.end());
  }

  void find_insides(Plane& plane) {
    plane.inside.resize(places_.size());
    plane.distance.resize(places_.size());
    if (places_.empty()) return;
    inside_.take(plane.voxels);
    const auto whole_plane = static_cast<float>(columns_ + rows_);
    std::span<const float> run;
    std::size_t first = 0;
    std::size_t last = 0;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (places_[p] >= last) run = inside_.measure_run(places_[p], first, last);
      plane.inside[p] = std::min(run[places_[p] - first], whole_plane);
    }
  }

  /// No label reaches further inside than the one that takes its place is away; that one may be
  /// missing in the plane.
  void limit_insides() {
    for (const T label : labels_) {
      limit_inside(label, below_, above_);
      limit_inside(label, above_, below_);
    }
  }

  /// label  which `from` may lack, and `into` has instead of what `from` has
  void limit_inside(T label, Plane& from, const Plane& into) {
    if (std::find(from.voxels.begin(), from.voxels.end(), label) != from.voxels.end()) return;
    const float reach = reach_of(label, into);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (into.voxels[places_[p]] == label) from.inside[p] = std::min(from.inside[p], reach);
    }
  }

  float reach_of(T label, const Plane& plane) const {
    float reach = 0;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      if (plane.voxels[places_[p]] == label) reach = std::max(reach, plane.inside[p]);
    }
    return reach;
  }

  /// Signed distances of `label` at all places, in both planes.
  void measure(T label) {
    const bool is_below = measure_in(below_, label);
    const bool is_above = measure_in(above_, label);
    if (!is_below) measure_missing(label, below_, above_);
    if (!is_above) measure_missing(label, above_, below_);
  }

  bool measure_in(Plane& plane, T label) {
    for (std::size_t i = 0; i < mask_.size(); ++i) mask_[i] = plane.voxels[i] == label ? 1 : 0;
    if (!sites_.mark(mask_)) return false;
    measure_places([&](std::size_t p, const SiteDistance::Nearest& nearest) {
      plane.distance[p] = plane.voxels[places_[p]] == label ? plane.inside[p]
                                                            : -border_distance(nearest.squared);
    });
    return true;
  }

  void measure_missing(T label, Plane& missing, const Plane& other) {
    const float reach = reach_of(label, other);
    for (std::size_t p = 0; p < places_.size(); ++p) {
      missing.distance[p] = std::min(0.0F, other.distance[p]) - reach;
    }
  }

  /// Calls f(place, nearest site) for all places; only their rows are measured.
  template <class F>
  void measure_places(F&& f) {
    std::size_t row = rows_;
    for (std::size_t p = 0; p < places_.size(); ++p) {
      const std::size_t y = places_[p] / columns_;
      if (y != row) sites_.measure_row(static_cast<std::int64_t>(row = y), row_);
      f(p, row_[places_[p] - y * columns_]);
    }
  }

  /// The nearest of the labels whose pixels are the same in both planes.
  void propose_unchanged() {
    for (std::size_t i = 0; i < mask_.size(); ++i) {
      mask_[i] = std::binary_search(labels_.begin(), labels_.end(), below_.voxels[i]) ? 0 : 1;
    }
    if (!sites_.mark(mask_)) return;
    measure_places([&](std::size_t p, const SiteDistance::Nearest& nearest) {
      const float distance = -border_distance(nearest.squared);
      propose(p, below_.voxels[static_cast<std::size_t>(nearest.index)], distance, distance);
    });
  }

  void propose(std::size_t p, T label, float below, float above) {
    for (std::size_t w = 0; w < ways_.size(); ++w) {
      const auto score = static_cast<float>((ways_[w].whole - ways_[w].part) * below +
                                            ways_[w].part * above);
      const std::size_t at = w * places_.size() + p;
      if (score < scores_[at]) continue;
      if (score == scores_[at] && !is_preferred(p, ways_[w], label, winners_[at])) continue;
      scores_[at] = score;
      winners_[at] = label;
    }
  }

  bool is_preferred(std::size_t p, const WayUp& way, T label, T other) const {
    const bool is_low = way.part <= way.whole - way.part;
    const T near = (is_low ? below_ : above_).voxels[places_[p]];
    const T far = (is_low ? above_ : below_).voxels[places_[p]];
    for (const T wanted : {near, far}) {
      if (label == wanted || other == wanted) return label == wanted;
    }
    return label < other;
  }

  std::size_t columns_;
  std::size_t rows_;
  Plane below_;
  Plane above_;
  InsideDistance<T> inside_;
  SiteDistance sites_;
  std::vector<std::uint8_t> mask_;
  std::vector<SiteDistance::Nearest> row_;
  std::vector<std::size_t> places_;  ///< where the planes differ, in order
  std::vector<T> labels_;            ///< that any place has, in order
  std::size_t note_limit_ = std::size_t{1} << 16;  ///< labels noted before they are sorted
  std::vector<WayUp> ways_;
  std::vector<float> scores_;        ///< [way][place]
  std::vector<T> winners_;           ///< [way][place]
};

}  // namespace

std::uint64_t ShapeBetween::memory_bytes(std::int64_t columns, std::int64_t rows, VoxelType type) {
  const auto pixels = static_cast<std::uint64_t>(columns) * static_cast<std::uint64_t>(rows);
  const auto bytes = static_cast<std::uint64_t>(bytes_per_voxel(type));
  const std::uint64_t decision = sizeof(float) + bytes;
  return pixels * (2 * bytes + kWorkBytes) +
         std::max(decision * pixels, std::min(kDecisionBytes, decision * kMostWays * pixels));
}

std::unique_ptr<ShapeBetween> make_shape_between(std::int64_t columns, std::int64_t rows,
                                                 VoxelType type) {
  return with_voxel_type(type, [&](auto tag) -> std::unique_ptr<ShapeBetween> {
    using T = typename decltype(tag)::type;
    if constexpr (std::is_integral_v<T>) {
      return std::make_unique<ShapesOf<T>>(columns, rows);
    } else {
      throw Error(ErrorKind::invalid_argument, "labels are integers; these voxels are float32");
    }
  });
}

}  // namespace octavo
