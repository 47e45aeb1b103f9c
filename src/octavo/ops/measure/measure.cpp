#include "octavo/ops/measure/measure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/label/label_block.h"
#include "octavo/ops/measure/moment_sums.h"

namespace octavo {

namespace {

// Bricks whose sums are held until they are added in order.
constexpr std::int64_t kBricksAtOnce = 64;

// How many voxels fell into each bin. A few are kept one by one: most regions of a brick, and many
// of a volume, have fewer voxels than there are bins.
class Histogram {
 public:
  void add(std::size_t bin) {
    if (counts_.empty() && few_.size() < kFew) {
      few_.push_back(static_cast<std::uint16_t>(bin));
    } else {
      spread();
      ++counts_[bin];
    }
  }

  void add(const Histogram& other) {
    if (other.counts_.empty()) {
      for (const std::uint16_t bin : other.few_) add(bin);
      return;
    }
    spread();
    for (std::size_t bin = 0; bin < counts_.size(); ++bin) counts_[bin] += other.counts_[bin];
  }

  /// The count of every bin.
  std::vector<std::uint64_t> counts() const {
    Histogram all = *this;
    all.spread();
    return all.counts_;
  }

 private:
  static constexpr std::size_t kFew = 4 * static_cast<std::size_t>(kPercentileBins);

  void spread() {
    if (!counts_.empty()) return;
    counts_.resize(static_cast<std::size_t>(kPercentileBins));
    for (const std::uint16_t bin : std::exchange(few_, {})) ++counts_[bin];
  }

  std::vector<std::uint16_t> few_;
  std::vector<std::uint64_t> counts_;
};

// Sums over the voxels of one region.
struct Sums {
  MomentSums moments;
  std::uint64_t surface = 0;
  // Of the grey voxels less `Bins::minimum`: exact for integers, in order for floats.
  double minimum = std::numeric_limits<double>::infinity();
  double maximum = -std::numeric_limits<double>::infinity();
  __int128 whole_sum = 0;
  __int128 whole_squares = 0;
  long double sum = 0;
  long double squares = 0;
  Histogram histogram;
};

// How grey values fall into bins: the k-th holds those from minimum + k * width on. Sums count from
// the smallest value as well, so that a small spread far from 0 is not lost.
struct Bins {
  double minimum = 0;
  double width = 1;
  std::size_t count = 1;
  bool is_wanted = false;

  std::size_t bin_of(double value) const {
    const double at = std::floor((value - minimum) / width);
    return static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(count - 1)));
  }
};

Bins bins_of(const FileReader& grey) {
  const VolumeDescription& description = grey.description();
  const double a = description.voxel_of(grey.range().min);
  const double b = description.voxel_of(grey.range().max);
  Bins bins{std::min(a, b), 1, 1};
  const double range = std::abs(b - a);
  if (is_integer(description.type) && range < static_cast<double>(kPercentileBins)) {
    bins.count = static_cast<std::size_t>(range) + 1;
  } else if (range > 0) {
    bins.count = static_cast<std::size_t>(kPercentileBins);
    bins.width = range / static_cast<double>(kPercentileBins);
  }
  return bins;
}

template <class T>
void add_grey(T value, const Bins& bins, Sums& sums) {
  const auto v = static_cast<double>(value);
  sums.minimum = std::min(sums.minimum, v);
  sums.maximum = std::max(sums.maximum, v);
  if constexpr (std::is_integral_v<T>) {
    const auto above = static_cast<std::int64_t>(value) - static_cast<std::int64_t>(bins.minimum);
    sums.whole_sum += above;
    sums.whole_squares += static_cast<__int128>(above) * above;
  } else {
    const long double above = v - bins.minimum;
    sums.sum += above;
    sums.squares += above * above;
  }
  if (bins.is_wanted) sums.histogram.add(bins.bin_of(v));
}

using GreyByLabel = std::map<std::int64_t, Sums>;

void add(const Sums& from, Sums& to) {
  to.moments.add(from.moments);
  to.surface += from.surface;
  to.minimum = std::min(to.minimum, from.minimum);
  to.maximum = std::max(to.maximum, from.maximum);
  to.whole_sum += from.whole_sum;
  to.whole_squares += from.whole_squares;
  to.sum += from.sum;
  to.squares += from.squares;
  to.histogram.add(from.histogram);
}

class Measurement {
 public:
  Measurement(const FileReader& labels, const FileReader* grey,
              const RegionMeasureOptions& options)
      : labels_(labels), grey_(grey), options_(options), grid_(labels.levels().brick_grid(0)) {
    if (grey == nullptr) return;
    bins_ = bins_of(*grey);
    bins_.is_wanted = !options.percentiles.empty();
  }

  std::vector<RegionMeasure> take(Progress& progress) {
    const std::int64_t count = grid_.voxel_count();
    const ProgressScope scope(progress, "measure", count, "bricks");
    for (std::int64_t first = 0; first < count; first += kBricksAtOnce) {
      const std::int64_t end = std::min(count, first + kBricksAtOnce);
      std::vector<GreyByLabel> of_bricks(static_cast<std::size_t>(end - first));
      tbb::parallel_for(first, end, [&](std::int64_t i) {
        if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while measuring");
        of_bricks[static_cast<std::size_t>(i - first)] = brick_sums(
            {i % grid_.x, i / grid_.x % grid_.y, i / (grid_.x * grid_.y)});
        progress.advance(1);
      });
      for (const GreyByLabel& of_brick : of_bricks) {
        for (const auto& [label, sums] : of_brick) add(sums, totals_[label]);
      }
    }
    std::vector<RegionMeasure> regions;
    for (const auto& [label, sums] : totals_) regions.push_back(region_of(label, sums));
    return regions;
  }

 private:
  // The label of a brick of one label only.
  std::optional<std::int64_t> single_label(const Index3& brick) const {
    const BrickEntry entry = labels_.brick(0, brick);
    if (!entry.is_uniform()) return std::nullopt;
    return entry.range.min;
  }

  // Whether no voxel of a brick of one label touches another label or the border of the volume.
  bool is_enclosed(const Index3& brick, std::int64_t label) const {
    for (int axis = 0; axis < 3; ++axis) {
      for (const std::int64_t step : {-1, 1}) {
        Index3 beside = brick;
        beside[axis] += step;
        if (beside[axis] < 0 || beside[axis] >= grid_[axis]) return false;
        if (single_label(beside) != label) return false;
      }
    }
    return true;
  }

  bool is_asked(std::int64_t label) const {
    const std::vector<std::int64_t>& asked = options_.labels;
    if (asked.empty()) return label != 0;
    return std::binary_search(asked.begin(), asked.end(), label);
  }

  // Whether the range of a brick leaves room for a label that is asked for.
  bool may_hold_asked(const Index3& brick) const {
    const ValueRange range = labels_.brick(0, brick).range;
    const std::vector<std::int64_t>& asked = options_.labels;
    if (asked.empty()) return range.min != 0 || range.max != 0;
    const auto first = std::lower_bound(asked.begin(), asked.end(), range.min);
    return first != asked.end() && *first <= range.max;
  }

  GreyByLabel brick_sums(const Index3& brick) const {
    const Box box = labels_.levels().brick_box(0, brick);
    const auto label = single_label(brick);
    GreyByLabel sums;
    if (!may_hold_asked(brick)) return sums;
    if (label && is_enclosed(brick, *label)) {
      sums[*label].moments.add_box(box);
      add_grey_of(box, sums[*label]);
      return sums;
    }
    LabelBlock block(labels_, box);
    if (grey_ == nullptr) {
      add_runs(box, block, sums,
               [](std::int64_t, std::int64_t, std::int64_t, std::int64_t, Sums&) {});
      return sums;
    }
    with_voxel_type(grey_->description().type, [&](auto id) {
      using T = typename decltype(id)::type;
      const std::vector<T> values = grey_voxels<T>(box);
      const Size3 size = box.size();
      add_runs(box, block, sums,
               [&](std::int64_t lo, std::int64_t hi, std::int64_t y, std::int64_t z, Sums& to) {
                 const T* const row = values.data() + (z * size.y + y) * size.x;
                 for (std::int64_t x = lo; x < hi; ++x) add_grey(row[x], bins_, to);
               });
    });
    return sums;
  }

  // The runs of one label in the rows of a brick.
  template <class TakeRun>
  void add_runs(const Box& box, LabelBlock& block, GreyByLabel& sums, TakeRun take_run) const {
    const Size3 size = box.size();
    std::optional<std::int64_t> last_label;
    Sums* last = nullptr;  // nullptr: not asked for
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        const std::int64_t* const row = block.row(y, z);
        for (std::int64_t lo = 0; lo < size.x;) {
          const std::int64_t label = row[lo];
          std::int64_t hi = lo + 1;
          while (hi < size.x && row[hi] == label) ++hi;
          if (label != last_label) {
            last_label = label;
            last = is_asked(label) ? &sums[label] : nullptr;
          }
          if (last != nullptr) {
            last->moments.add_box({{box.lo.x + lo, box.lo.y + y, box.lo.z + z},
                                   {box.lo.x + hi, box.lo.y + y + 1, box.lo.z + z + 1}});
            last->surface += block.surface_of(lo, hi, y, z);
            take_run(lo, hi, y, z, *last);
          }
          lo = hi;
        }
      }
    }
  }

  template <class T>
  std::vector<T> grey_voxels(const Box& box) const {
    std::vector<T> values(static_cast<std::size_t>(box.size().voxel_count()));
    grey_->read(box, 0, values.data());
    return values;
  }

  // All grey voxels of a box of one label.
  void add_grey_of(const Box& box, Sums& sums) const {
    if (grey_ == nullptr) return;
    with_voxel_type(grey_->description().type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (const T value : grey_voxels<T>(box)) add_grey(value, bins_, sums);
    });
  }

  RegionMeasure region_of(std::int64_t label, const Sums& sums) const {
    RegionMeasure region;
    region.label = label;
    region.voxel_count = sums.moments.count;
    region.surface_voxel_count = sums.surface;
    region.box = sums.moments.box;
    region.centroid = sums.moments.centroid();
    region.covariance = sums.moments.covariance();
    if (grey_ != nullptr) region.grey = grey_of(sums);
    return region;
  }

  GreyStatistics grey_of(const Sums& sums) const {
    GreyStatistics grey;
    const bool is_whole = is_integer(grey_->description().type);
    const auto count = static_cast<long double>(sums.moments.count);
    const long double sum = is_whole ? static_cast<long double>(sums.whole_sum) : sums.sum;
    const long double squares =
        is_whole ? static_cast<long double>(sums.whole_squares) : sums.squares;
    const long double mean = sum / count;
    grey.minimum = sums.minimum;
    grey.maximum = sums.maximum;
    grey.mean = static_cast<double>(mean + bins_.minimum);
    grey.sum = static_cast<double>(sum + count * bins_.minimum);
    grey.deviation =
        static_cast<double>(std::sqrt(std::max(0.0L, squares / count - mean * mean)));
    if (options_.percentiles.empty()) return grey;
    const std::vector<std::uint64_t> counts = sums.histogram.counts();
    for (const double percent : options_.percentiles) {
      grey.percentiles.push_back(percentile(sums, counts, percent));
    }
    return grey;
  }

  // The smallest value that at least `percent` of the voxels do not exceed, as far as bins tell.
  double percentile(const Sums& sums, const std::vector<std::uint64_t>& counts,
                    double percent) const {
    const double wanted = percent / 100 * static_cast<double>(sums.moments.count);
    std::uint64_t seen = 0;
    for (std::size_t bin = 0; bin < counts.size(); ++bin) {
      seen += counts[bin];
      if (seen > 0 && static_cast<double>(seen) >= wanted) {
        const double value = bins_.minimum + static_cast<double>(bin) * bins_.width;
        return std::clamp(value, sums.minimum, sums.maximum);
      }
    }
    return sums.maximum;
  }

  const FileReader& labels_;
  const FileReader* grey_;
  const RegionMeasureOptions& options_;
  Size3 grid_;
  Bins bins_;
  GreyByLabel totals_;
};

// Diagonalises a symmetric matrix by Jacobi rotations; columns of `vectors` become its axes.
void diagonalise(double (&m)[3][3], double (&vectors)[3][3]) {
  constexpr int kSweeps = 32;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) vectors[i][j] = i == j ? 1 : 0;
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (m[p][q] == 0) continue;
        const double theta = (m[q][q] - m[p][p]) / (2 * m[p][q]);
        const double t = (theta >= 0 ? 1 : -1) / (std::abs(theta) + std::hypot(theta, 1));
        const double c = 1 / std::hypot(t, 1);
        const double s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = m[k][p];
          const double kq = m[k][q];
          m[k][p] = c * kp - s * kq;
          m[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = m[p][k];
          const double qk = m[q][k];
          m[p][k] = c * pk - s * qk;
          m[q][k] = s * pk + c * qk;
        }
        for (int k = 0; k < 3; ++k) {
          const double kp = vectors[k][p];
          const double kq = vectors[k][q];
          vectors[k][p] = c * kp - s * kq;
          vectors[k][q] = s * kp + c * kq;
        }
      }
    }
  }
}

}  // namespace

std::vector<RegionMeasure> measure_regions(const FileReader& labels, const FileReader* grey,
                                           const RegionMeasureOptions& options,
                                           Progress& progress) {
  if (labels.description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels",
                labels.source().name());
  }
  if (grey != nullptr && grey->levels().size(0) != labels.levels().size(0)) {
    throw Error(ErrorKind::invalid_argument, "has another size than the labels",
                grey->source().name());
  }
  return Measurement(labels, grey, options).take(progress);
}

PrincipalAxes principal_axes(const RegionMeasure& region, const Geometry& geometry) {
  const auto& c = region.covariance;
  const double index[3][3] = {{c[0], c[3], c[4]}, {c[3], c[1], c[5]}, {c[4], c[5], c[2]}};
  // world = D S index S D^T
  double to_mm[3][3];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      to_mm[i][j] = geometry.direction[3 * i + j] * geometry.spacing_mm[j];
  double world[3][3] = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) world[i][j] += to_mm[i][k] * index[k][l] * to_mm[j][l];
  double vectors[3][3];
  diagonalise(world, vectors);
  std::array<int, 3> order = {0, 1, 2};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return world[a][a] > world[b][b]; });
  PrincipalAxes axes;
  for (std::size_t i = 0; i < 3; ++i) {
    const int column = order[i];
    axes.moments_mm2[i] = std::max(0.0, world[column][column]);
    Point3& axis = axes.axes[i];
    std::size_t largest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      axis[k] = vectors[k][column];
      if (std::abs(axis[k]) > std::abs(axis[largest]) + 1e-9) largest = k;
    }
    if (axis[largest] < 0)
      for (double& part : axis) part = -part;
  }
  return axes;
}

}  // namespace octavo
