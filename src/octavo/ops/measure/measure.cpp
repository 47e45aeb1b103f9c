#include "octavo/ops/measure/measure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "octavo/core/error.h"
#include "octavo/ops/label/label_block.h"
#include "octavo/ops/measure/moment_sums.h"
#include "octavo/ops/measure/percentiles.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

// Bricks whose sums are held until they are added in order.
constexpr std::int64_t kBricksAtOnce = 64;

// Values that parts can count one by one.
constexpr int kMostPartBits = 16;

// Sums, and the first pass of percentiles.
struct Sums : RegionSums {
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
    sums.floats.add(value);
  }
  if (scale.search) sums.histogram.add(scale.search->first_bin(scale.keys->key_of(value)));
}

using GreyByLabel = std::map<std::int64_t, Sums>;

void add(const Sums& from, Sums& to) {
  to.RegionSums::add(from);
  to.histogram.add(from.histogram);
}

class Measurement {
 public:
  Measurement(const FileReader& labels, const FileReader* grey,
              const RegionMeasureOptions& options, const WorkPart& part)
      : labels_(labels),
        grey_(grey),
        options_(options),
        part_(part),
        grid_(labels.levels().brick_grid(0)) {
    if (grey == nullptr) return;
    scale_ = scale_of(*grey, options);
  }

  std::vector<RegionMeasure> take(Progress& progress) {
    sum_bricks(progress);
    if (scale_.search) find_percentiles(progress);
    std::vector<RegionMeasure> regions;
    for (const auto& [label, sums] : totals_) {
      regions.push_back(measured_by(label, sums, grey_));
      if (scale_.search) regions.back().grey->percentiles = scale_.search->values_of(label);
    }
    return regions;
  }

  PartOfRegions take_part(Progress& progress) {
    const int bits = scale_.keys ? scale_.keys->bit_count() : 0;
    if (bits > kMostPartBits) {
      throw Error(ErrorKind::invalid_argument,
                  "percentiles of values that span over more than 2^16 take passes that parts do "
                  "not make",
                  grey_->source().name())
          .with_field("percentiles");
    }
    sum_bricks(progress);
    PartOfRegions regions;
    for (const auto& [label, sums] : totals_) {
      PartOfRegion& region = regions[label];
      region.sums = sums;
      if (!scale_.search || bits > kPercentileBits) continue;
      const std::vector<std::uint64_t> counts = sums.histogram.counts();
      for (std::size_t key = 0; key < counts.size(); ++key) {
        if (counts[key] > 0) region.values[key] = counts[key];
      }
    }
    if (bits > kPercentileBits) count_values(progress, regions);
    return regions;
  }

 private:
  void sum_bricks(Progress& progress) {
    for_bricks<GreyByLabel>(
        progress, "measure", [&](const Index3& brick) { return brick_sums(brick); },
        [&](const GreyByLabel& of_brick) {
          for (const auto& [label, sums] : of_brick) add(sums, totals_[label]);
        });
  }

  // Calls make(brick) for every brick on all threads, and take(what it gave) in file order.
  template <class Made, class Make, class Take>
  void for_bricks(Progress& progress, const char* what, Make make, Take take) const {
    const std::int64_t begin = part_.begin_of(grid_.z) * grid_.x * grid_.y;
    const std::int64_t last = part_.end_of(grid_.z) * grid_.x * grid_.y;
    const ProgressScope scope(progress, what, last - begin, "bricks");
    for (std::int64_t first = begin; first < last; first += kBricksAtOnce) {
      const std::int64_t end = std::min(last, first + kBricksAtOnce);
      std::vector<Made> of_bricks(static_cast<std::size_t>(end - first));
      parallel_for(first, end, [&](std::int64_t i) {
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
    visit_values(box, [&](std::int64_t label, auto first, auto last) {
      const PercentileSearch::Places& places = search.places_of(label);
      PercentileSearch::Counted& counted = found[label];
      for (; first != last; ++first) {
        if (is_finite(*first)) search.count(places, scale_.keys->key_of(*first), counted);
      }
    });
    return found;
  }

  // Calls visit(label, first value, end of them) for the runs of voxels that are asked for.
  template <class Visit>
  void visit_values(const Box& box, Visit visit) const {
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
            if (is_asked(labels[lo])) visit(labels[lo], row + lo, row + hi);
          }
        }
      }
    });
  }

  // One more pass, over all values of regions.
  void count_values(Progress& progress, PartOfRegions& regions) const {
    using Keys = std::map<std::int64_t, std::vector<std::uint16_t>>;
    const auto keys_in = [&](const Index3& brick) {
      Keys keys;
      if (!may_hold_asked(brick)) return keys;
      const Box box = labels_.levels().brick_box(0, brick);
      visit_values(box, [&](std::int64_t label, auto first, auto last) {
        std::vector<std::uint16_t>& of_label = keys[label];
        for (; first != last; ++first) {
          if (!is_finite(*first)) continue;
          of_label.push_back(static_cast<std::uint16_t>(scale_.keys->key_of(*first)));
        }
      });
      for (auto& [label, of_label] : keys) std::ranges::sort(of_label);
      return keys;
    };
    for_bricks<Keys>(progress, "measure percentiles", keys_in, [&](const Keys& of_brick) {
      for (const auto& [label, keys] : of_brick) {
        std::map<std::uint64_t, std::uint64_t>& values = regions[label].values;
        for (auto key = keys.begin(), next = key; key != keys.end(); key = next) {
          next = std::upper_bound(key, keys.end(), *key);
          values[*key] += static_cast<std::uint64_t>(next - key);
        }
      }
    });
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

  const FileReader& labels_;
  const FileReader* grey_;
  const RegionMeasureOptions& options_;
  WorkPart part_;
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

void check_volumes(const FileReader& labels, const FileReader* grey) {
  if (labels.description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels",
                labels.source().name());
  }
  if (grey != nullptr && grey->levels().size(0) != labels.levels().size(0)) {
    throw Error(ErrorKind::invalid_argument, "has another size than the labels",
                grey->source().name());
  }
}

}  // namespace

std::vector<RegionMeasure> measure_regions(const FileReader& labels, const FileReader* grey,
                                           const RegionMeasureOptions& options,
                                           Progress& progress) {
  check_volumes(labels, grey);
  return Measurement(labels, grey, options, {}).take(progress);
}

PartOfRegions measure_part(const FileReader& labels, const FileReader* grey,
                           const RegionMeasureOptions& options, const WorkPart& part,
                           Progress& progress) {
  check_volumes(labels, grey);
  require_part(part);
  return Measurement(labels, grey, options, part).take_part(progress);
}

void add_part(const PartOfRegions& part, PartOfRegions& all) {
  for (const auto& [label, region] : part) {
    PartOfRegion& to = all[label];
    to.sums.add(region.sums);
    for (const auto& [key, count] : region.values) to.values[key] += count;
  }
}

std::vector<RegionMeasure> joined_regions(const PartOfRegions& all, const FileReader* grey,
                                          const RegionMeasureOptions& options) {
  std::vector<RegionMeasure> regions;
  std::optional<ValueKeys> keys;
  if (grey != nullptr && !options.percentiles.empty()) keys.emplace(*grey);
  for (const auto& [label, region] : all) {
    regions.push_back(measured_by(label, region.sums, grey));
    if (!keys) continue;
    regions.back().grey->percentiles =
        percentiles_of(region.values, *keys, options.percentiles, options.falls);
  }
  return regions;
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
