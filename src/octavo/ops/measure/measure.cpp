#include "octavo/ops/measure/measure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/ops/label/label_block.h"
#include "octavo/ops/measure/moment_sums.h"
#include "octavo/ops/measure/percentiles.h"

namespace octavo {

namespace {

// Bricks whose sums are held until they are added in order.
constexpr std::int64_t kBricksAtOnce = 64;

// Sums of floats less the first of them, so that a small spread far from 0 is not lost. The first
// one is a value of the region: what the index says of the volume may lie as far off as floats go.
class FloatSums {
 public:
  void add(double value) {
    if (count_ == 0) first_ = value;
    const long double above = static_cast<long double>(value) - first_;
    ++count_;
    sum_ += above;
    squares_ += above * above;
  }

  void add(const FloatSums& other) {
    if (other.count_ == 0) return;
    if (count_ == 0) first_ = other.first_;
    const long double shift = static_cast<long double>(other.first_) - first_;
    const auto count = static_cast<long double>(other.count_);
    count_ += other.count_;
    sum_ += other.sum_ + count * shift;
    squares_ += other.squares_ + 2 * shift * other.sum_ + count * shift * shift;
  }

  double first() const { return first_; }
  long double sum() const { return sum_; }
  long double squares() const { return squares_; }

 private:
  double first_ = 0;
  std::uint64_t count_ = 0;
  long double sum_ = 0;
  long double squares_ = 0;
};

// Sums over the voxels of one region.
struct Sums {
  MomentSums moments;
  std::uint64_t surface = 0;
  std::uint64_t not_finite = 0;  // grey voxels that enter none of the following
  double minimum = std::numeric_limits<double>::infinity();
  double maximum = -std::numeric_limits<double>::infinity();
  // Of integers less `GreyScale::minimum`: exact
  __int128 whole_sum = 0;
  __int128 whole_squares = 0;
  FloatSums floats;
  Histogram histogram;
};

// How grey values are summed.
struct GreyScale {
  std::int64_t minimum = 0;       // of integers
  std::optional<ValueKeys> keys;  // where percentiles are asked for
  std::optional<PercentileSearch> search;
};

GreyScale scale_of(const FileReader& grey, const RegionMeasureOptions& options) {
  GreyScale scale;
  if (is_integer(grey.description().type)) scale.minimum = grey.range().min;
  if (options.percentiles.empty()) return scale;
  scale.keys.emplace(grey);
  scale.search.emplace(*scale.keys, options.percentiles, options.falls);
  return scale;
}

template <class T>
bool is_finite(T value) {
  if constexpr (std::is_integral_v<T>) return true;
  else return std::isfinite(value);
}

template <class T>
void add_grey(T value, const GreyScale& scale, Sums& sums) {
  if (!is_finite(value)) {
    ++sums.not_finite;
    return;
  }
  const auto v = static_cast<double>(value);
  sums.minimum = std::min(sums.minimum, v);
  sums.maximum = std::max(sums.maximum, v);
  if constexpr (std::is_integral_v<T>) {
    const auto above = static_cast<std::int64_t>(value) - scale.minimum;
    sums.whole_sum += above;
    sums.whole_squares += static_cast<__int128>(above) * above;
  } else {
    sums.floats.add(v);
  }
  if (scale.search) sums.histogram.add(scale.search->first_bin(scale.keys->key_of(value)));
}

using GreyByLabel = std::map<std::int64_t, Sums>;

void add(const Sums& from, Sums& to) {
  to.moments.add(from.moments);
  to.surface += from.surface;
  to.not_finite += from.not_finite;
  to.minimum = std::min(to.minimum, from.minimum);
  to.maximum = std::max(to.maximum, from.maximum);
  to.whole_sum += from.whole_sum;
  to.whole_squares += from.whole_squares;
  to.floats.add(from.floats);
  to.histogram.add(from.histogram);
}

class Measurement {
 public:
  Measurement(const FileReader& labels, const FileReader* grey,
              const RegionMeasureOptions& options)
      : labels_(labels), grey_(grey), options_(options), grid_(labels.levels().brick_grid(0)) {
    if (grey == nullptr) return;
    scale_ = scale_of(*grey, options);
  }

  std::vector<RegionMeasure> take(Progress& progress) {
    for_bricks<GreyByLabel>(
        progress, "measure", [&](const Index3& brick) { return brick_sums(brick); },
        [&](const GreyByLabel& of_brick) {
          for (const auto& [label, sums] : of_brick) add(sums, totals_[label]);
        });
    if (scale_.search) find_percentiles(progress);
    std::vector<RegionMeasure> regions;
    for (const auto& [label, sums] : totals_) regions.push_back(region_of(label, sums));
    return regions;
  }

 private:
  // Calls make(brick) for every brick on all threads, and take(what it gave) in file order.
  template <class Made, class Make, class Take>
  void for_bricks(Progress& progress, const char* what, Make make, Take take) const {
    const std::int64_t count = grid_.voxel_count();
    const ProgressScope scope(progress, what, count, "bricks");
    for (std::int64_t first = 0; first < count; first += kBricksAtOnce) {
      const std::int64_t end = std::min(count, first + kBricksAtOnce);
      std::vector<Made> of_bricks(static_cast<std::size_t>(end - first));
      tbb::parallel_for(first, end, [&](std::int64_t i) {
        if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while measuring");
        of_bricks[static_cast<std::size_t>(i - first)] =
            make(Index3{i % grid_.x, i / grid_.x % grid_.y, i / (grid_.x * grid_.y)});
        progress.advance(1);
      });
      for (const Made& of_brick : of_bricks) take(of_brick);
    }
  }

  // Passes over the voxels until every percentile is a value.
  void find_percentiles(Progress& progress) {
    PercentileSearch& search = *scale_.search;
    for (const auto& [label, sums] : totals_) {
      const std::uint64_t values = sums.moments.count - sums.not_finite;
      if (values > 0) search.begin(label, values, sums.histogram);
    }
    while (!search.is_settled()) {
      PercentileSearch::Found all;
      for_bricks<PercentileSearch::Found>(
          progress, "measure percentiles",
          [&](const Index3& brick) { return counted_in(brick, search); },
          [&](const PercentileSearch::Found& found) {
            for (const auto& [label, histograms] : found) {
              for (const auto& [prefix, counts] : histograms) all[label][prefix].add(counts);
            }
          });
      search.take(all);
    }
  }

  // What a pass counts in a brick.
  PercentileSearch::Found counted_in(const Index3& brick, const PercentileSearch& search) const {
    PercentileSearch::Found found;
    const Box box = labels_.levels().brick_box(0, brick);
    if (!may_hold_asked(brick) || !may_count(brick, box, search)) return found;
    LabelBlock block(labels_, box);
    with_voxel_type(grey_->description().type, [&](auto id) {
      using T = typename decltype(id)::type;
      const std::vector<T> values = grey_voxels<T>(box);
      const Size3 size = box.size();
      for (std::int64_t z = 0; z < size.z; ++z) {
        for (std::int64_t y = 0; y < size.y; ++y) {
          const std::int64_t* const labels = block.row(y, z);
          const T* const row = values.data() + (z * size.y + y) * size.x;
          for (std::int64_t lo = 0, hi = 0; lo < size.x; lo = hi) {
            while (hi < size.x && labels[hi] == labels[lo]) ++hi;
            if (!is_asked(labels[lo])) continue;
            const PercentileSearch::Places& places = search.places_of(labels[lo]);
            PercentileSearch::Counted& counted = found[labels[lo]];
            for (std::int64_t x = lo; x < hi; ++x) {
              if (!is_finite(row[x])) continue;
              search.count(places, scale_.keys->key_of(row[x]), counted);
            }
          }
        }
      }
    });
    return found;
  }

  // Whether the range of the grey brick at the same place has room for what a pass counts.
  bool may_count(const Index3& brick, const Box& box, const PercentileSearch& search) const {
    if (grey_->levels().brick_grid(0) != grid_ || grey_->levels().brick_box(0, brick) != box) {
      return true;
    }
    const ValueRange range = grey_->brick(0, brick).range;
    const VolumeDescription& description = grey_->description();
    std::uint64_t ends[2];
    with_voxel_type(description.type, [&](auto id) {
      using T = typename decltype(id)::type;
      ends[0] = scale_.keys->key_of(static_cast<T>(description.voxel_of(range.min)));
      ends[1] = scale_.keys->key_of(static_cast<T>(description.voxel_of(range.max)));
    });
    return search.may_count(std::min(ends[0], ends[1]), std::max(ends[0], ends[1]));
  }

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
                 for (std::int64_t x = lo; x < hi; ++x) add_grey(row[x], scale_, to);
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
      for (const T value : grey_voxels<T>(box)) add_grey(value, scale_, sums);
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
    if (scale_.search) region.grey->percentiles = scale_.search->values_of(label);
    return region;
  }

  GreyStatistics grey_of(const Sums& sums) const {
    GreyStatistics grey;
    grey.not_finite = sums.not_finite;
    if (sums.moments.count == sums.not_finite) {
      grey.minimum = grey.maximum = grey.mean = grey.deviation = grey.sum = std::nan("");
      return grey;
    }
    const bool is_whole = is_integer(grey_->description().type);
    const auto count = static_cast<long double>(sums.moments.count - sums.not_finite);
    const long double first =
        is_whole ? static_cast<long double>(scale_.minimum) : sums.floats.first();
    const long double sum =
        is_whole ? static_cast<long double>(sums.whole_sum) : sums.floats.sum();
    const long double squares =
        is_whole ? static_cast<long double>(sums.whole_squares) : sums.floats.squares();
    const long double mean = sum / count;
    grey.minimum = sums.minimum;
    grey.maximum = sums.maximum;
    grey.mean = static_cast<double>(mean + first);
    grey.sum = static_cast<double>(sum + count * first);
    grey.deviation =
        static_cast<double>(std::sqrt(std::max(0.0L, squares / count - mean * mean)));
    return grey;
  }

  const FileReader& labels_;
  const FileReader* grey_;
  const RegionMeasureOptions& options_;
  Size3 grid_;
  GreyScale scale_;
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
