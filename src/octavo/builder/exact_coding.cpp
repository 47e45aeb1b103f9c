#include "octavo/builder/exact_coding.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "octavo/builder/float_grid.h"

namespace octavo {

namespace {

constexpr double kMedianOfDifference = 0.954;  // of two normal numbers of deviation 1
// A coding seen in fewer values than this may be chance.
constexpr std::size_t kEnoughMultiples = 64;
// Means between the smallest and the largest value take one of so many steps, or of more.
constexpr double kFewestSteps = 32;
constexpr double kMostFloat = std::numeric_limits<float>::max();

// Whether many of the values have floats beside them that are no multiples.
bool is_coarser_than_floats(const SampleCoding& coding, std::span<const float> values) {
  constexpr std::ptrdiff_t kMany = 16;  // one of so many
  const auto count = std::ranges::count_if(values, [&](float v) {
    return v != 0 && std::ldexp(1.0, std::ilogb(v) - 23) < coding.scale;
  });
  return count * kMany > static_cast<std::ptrdiff_t>(values.size());
}

// Each value counts once, however many voxels hold it, as the fill value of a background does.
std::vector<double> magnitudes_of(std::span<const float> values) {
  std::vector<double> magnitudes;
  for (const float v : values) magnitudes.push_back(std::abs(static_cast<double>(v)));
  std::sort(magnitudes.begin(), magnitudes.end());
  return magnitudes;
}

// The largest of ascending magnitudes that is not far beyond all others but a few.
double largest_but_few(std::span<const double> magnitudes, std::size_t few) {
  constexpr double kFar = 1 << 10;
  if (magnitudes.empty()) return 0;
  if (few >= magnitudes.size()) return magnitudes.back();
  const double usual = magnitudes[magnitudes.size() - 1 - few];
  if (usual == 0) return magnitudes.back();
  return *(std::upper_bound(magnitudes.begin(), magnitudes.end(), usual * kFar) - 1);
}

// How far values reach.
struct FloatExtent {
  double bulk = 0;   // of nearly all: what noise is looked for in
  double reach = 0;  // of all but a few, such as fill values: what codes shall hold
};

FloatExtent value_extent(std::span<const float> values) {
  constexpr std::size_t kShare = 64;  // one of so many values may lie beyond the bulk
  constexpr std::size_t kFew = 256;
  // No measured values of one volume differ by more.
  constexpr double kFarthest = 0x1p48;
  const std::vector<double> magnitudes = magnitudes_of(values);
  const std::size_t far = (magnitudes.size() + kShare - 1) / kShare;
  FloatExtent extent;
  extent.bulk = largest_but_few(magnitudes, far);
  extent.reach = std::clamp(largest_but_few(magnitudes, std::min(far, kFew)), extent.bulk,
                            extent.bulk * kFarthest);
  return extent;
}

// The floats that many voxels of some planes are, as the fill values of a background.
std::vector<float> frequent_values(const FloatStack& planes) {
  constexpr std::size_t kMany = 16;  // one of so many voxels
  constexpr std::size_t kSamples = 1 << 16;
  const std::size_t stride = planes.float_count() / kSamples + 1;
  std::vector<float> samples;
  for (std::size_t number = 0; number < planes.count(); ++number) {
    const std::span<const float> plane = planes.plane(number);
    for (std::size_t i = 0; i < plane.size(); i += stride) {
      if (std::isfinite(plane[i])) samples.push_back(plane[i]);
    }
  }
  std::sort(samples.begin(), samples.end());
  std::vector<float> frequent;
  for (auto from = samples.begin(); from != samples.end();) {
    const auto to = std::upper_bound(from, samples.end(), *from);
    if (static_cast<std::size_t>(to - from) * kMany > samples.size()) frequent.push_back(*from);
    from = to;
  }
  return frequent;
}

// Differences between voxels that follow each other, none of them 0.
class Differences {
 public:
  void start() { has_before_ = false; }
  void add(double value) {
    if (has_before_ && value != before_ && differences_.size() < kMost) {
      differences_.push_back(std::abs(value - before_));
    }
    before_ = value;
    has_before_ = true;
  }
  const std::vector<double>& all() const { return differences_; }
  bool is_full() const { return differences_.size() == kMost; }

 private:
  static constexpr std::size_t kMost = 1 << 20;
  std::vector<double> differences_;
  double before_ = 0;
  bool has_before_ = false;
};

// Differences that tell of noise: between neighbors of which neither is a frequent value; where
// these are rare, between voxels with frequent ones between them, or between all.
// frequent  values of these planes
std::vector<double> differences_between(const FloatStack& planes,
                                        const std::vector<float>& frequent, double bulk) {
  constexpr std::size_t kEnough = 16;
  Differences beside;
  Differences behind;
  Differences of_all;
  for (std::size_t number = 0; number < planes.count() && !beside.is_full(); ++number) {
    beside.start();
    of_all.start();
    for (const float voxel : planes.plane(number)) {
      const double value = voxel;
      if (!(std::abs(value) <= bulk)) {  // NaN as well
        beside.start();
        of_all.start();
        continue;
      }
      of_all.add(value);
      if (std::ranges::find(frequent, voxel) != frequent.end()) {
        beside.start();
      } else {
        beside.add(value);
        behind.add(value);
      }
    }
  }
  if (beside.all().size() >= kEnough) return beside.all();
  return behind.all().empty() ? of_all.all() : behind.all();
}

std::vector<float> within_bulk(const std::vector<float>& values, double bulk) {
  std::vector<float> usual;
  std::ranges::copy_if(values, std::back_inserter(usual), [bulk](float v) {
    return std::abs(static_cast<double>(v)) <= bulk;
  });
  return usual;
}

// Sorted values without the first and the last few, as far as these lie farther from the others
// than the others reach.
std::vector<float> without_lone_ends(std::vector<float> values) {
  constexpr std::size_t kMost = 4;
  std::span<const float> left(values);
  for (std::size_t i = 0; i < kMost && left.size() > 2; ++i) {
    const double spread = static_cast<double>(left.back()) - static_cast<double>(left.front());
    const auto is_far = [&](float a, float b) {
      return 2 * (static_cast<double>(b) - static_cast<double>(a)) > spread;
    };
    if (is_far(left[0], left[1])) left = left.subspan(1);
    else if (is_far(left[left.size() - 2], left.back())) left = left.first(left.size() - 1);
  }
  return {left.begin(), left.end()};
}

// Values that may be multiples of one number: all, or all but those that a program filled in.
std::vector<std::vector<float>> likely_multiples(const std::vector<float>& values, double bulk,
                                                 const std::vector<float>& frequent) {
  std::vector<std::vector<float>> choices = {values};
  const auto offer = [&](std::vector<float> some) {
    if (some.size() < choices.back().size()) choices.push_back(std::move(some));
  };
  offer(within_bulk(values, bulk));
  std::vector<float> rare = choices.back();
  std::erase_if(rare, [&](float v) { return std::ranges::find(frequent, v) != frequent.end(); });
  rare = without_lone_ends(std::move(rare));
  if (rare.size() >= kEnoughMultiples) offer(std::move(rare));
  return choices;
}

// A power of two that divides the noise into some steps: what is finer than a step no prediction
// would save, and bins between powers of two then hold as many floats.
// frequent  values of the first planes
double noise_step(const FloatSample& sample, const std::vector<float>& frequent,
                  const FloatExtent& extent) {
  constexpr int kSmallest = -148;  // half of it is a float
  constexpr double kStepsOfBulk = 1 << 20;
  constexpr double kStepsOfNoise = 8;
  constexpr double kStepsOfReach = 1 << 30;
  std::vector<double> differences = differences_between(sample.planes, frequent, extent.bulk);
  const std::vector<double> further =
      differences_between(sample.rows, frequent_values(sample.rows), extent.bulk);
  differences.insert(differences.end(), further.begin(), further.end());
  double noise = 0;
  if (!differences.empty()) {
    const auto middle =
        differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    noise = *middle / kMedianOfDifference;
  }
  int exponent = 0;
  std::frexp(std::max({noise / kStepsOfNoise, extent.bulk / kStepsOfBulk,
                       extent.reach / kStepsOfReach}),
             &exponent);
  return std::ldexp(1.0, std::max(exponent - 1, kSmallest));
}

// Steps far below the noise save nothing unless floats lie closer than they do.
bool is_useful(const SampleCoding& coding, std::span<const float> values, double noise_step) {
  constexpr double kMuchFiner = 32;
  return coding.scale * kMuchFiner > noise_step || is_coarser_than_floats(coding, values);
}

// The number that all values, or the likely ones among them, are multiples of.
std::optional<SampleCoding> multiples_in(const std::vector<float>& frequent,
                                         const std::vector<float>& values, double step,
                                         std::span<const SampleCoding> hints) {
  const FloatExtent extent = value_extent(values);
  for (const std::vector<float>& some : likely_multiples(values, extent.bulk, frequent)) {
    const auto coding = find_coding(some, hints);
    if (coding && is_useful(*coding, some, step)) return coding;
  }
  return std::nullopt;
}

bool holds_most(const SampleCoding& coding, std::span<const float> values) {
  constexpr std::ptrdiff_t kFew = 16;  // one of so many may be something else
  const auto others = std::ranges::count_if(
      values, [&](float v) { return !exact_code(coding, v).has_value(); });
  return others * kFew <= static_cast<std::ptrdiff_t>(values.size());
}

}  // namespace

SampleCoding exact_coding_of(const FloatSample& sample, std::span<const SampleCoding> hints) {
  const FloatExtent extent = value_extent(sample.values);
  const std::vector<float> frequent = frequent_values(sample.planes);
  const double step = noise_step(sample, frequent, extent);
  // What holds for those at the start, and for nearly all others; else what holds for all
  std::optional<SampleCoding> coding = multiples_in(frequent, sample.first_values, step, hints);
  if (!coding || !holds_most(*coding, sample.values)) {
    const auto of_all = multiples_in(frequent, sample.values, step, hints);
    if (of_all) coding = of_all;
  }
  const bool has_codes =
      coding && (extent.reach + std::abs(coding->offset)) / coding->scale < kLargestCode;
  if (!has_codes) coding = SampleCoding{VoxelType::int32, step, 0};
  coding->is_exact = true;
  return *coding;
}

std::optional<SampleCoding> coding_of_few(const FloatSample& sample, const SampleCoding& usual) {
  constexpr std::size_t kFewValues = 256;
  constexpr double kCodes = 256;
  const std::vector<float>& values = sample.values;
  if (values.size() < 2 || values.size() > kFewValues) return std::nullopt;
  const double first = values.front();
  const double last = values.back();
  SampleCoding coding{VoxelType::int32, 0, 0, true};
  if (values.size() == 2) {
    // As a mask: two codes, of which the smaller value has 0
    coding.offset = std::abs(first) < std::abs(last) ? first : last;
    coding.scale = last - first;
    const double usual_steps = (last - first) / usual.scale;
    const bool is_usual = usual_steps < 1.5 || usual_steps == kFewestSteps;
    const bool holds = exact_code(coding, values.front()) && exact_code(coding, values.back());
    return is_usual || !holds ? std::nullopt : std::optional(coding);
  }
  // The values that codes shall hold, without fill values
  const double reach = value_extent(values).reach;
  const auto is_near = [&](float v) { return std::abs(static_cast<double>(v)) <= reach; };
  const auto low = static_cast<double>(*std::ranges::find_if(values, is_near));
  const auto high = static_cast<double>(*std::find_if(values.rbegin(), values.rend(), is_near));
  int exponent = 0;
  std::frexp((high - low) / kCodes, &exponent);
  coding.scale = std::ldexp(1.0, exponent);
  return coding.scale <= usual.scale ? std::nullopt : std::optional(coding);
}

SampleCoding with_steps_for_means(const SampleCoding& coding, std::span<const float> values) {
  const auto code_of = [&](float v) {
    return (static_cast<double>(v) - coding.offset) / coding.scale;
  };
  const auto has_code = [&](float v) { return std::abs(code_of(v)) < kLargestCode; };
  const auto first = std::ranges::find_if(values, has_code);
  const auto last = std::find_if(values.rbegin(), values.rend(), has_code);
  if (first == values.end() || *first == *last) return coding;
  const double low = code_of(*first);
  const double high = code_of(*last);
  const double farthest = std::max(std::abs(low), std::abs(high));
  // A power of two, so that what was a code is one still
  double parts = 1;
  while (parts * (high - low) < kFewestSteps && 2 * parts * farthest < kLargestCode) parts *= 2;
  SampleCoding finer = coding;
  finer.scale = coding.scale / parts;
  return finer;
}

void count_clipped(const SampleCoding& coding, std::span<const float> voxels,
                   ClippedVoxels& clipped) {
  // The last code is 2^31 - 2; half a step beyond it a voxel has no nearest one.
  const double last = kLargestCode - 1;
  const double high = (last + 0.5) * coding.scale + coding.offset;
  const double low = (-last - 0.5) * coding.scale + coding.offset;
  if (high >= kMostFloat && low <= -kMostFloat) return;
  const auto is_beyond = [&](float v) {
    const double value = v;
    return (value > high) | (value < low);
  };
  std::int64_t count = 0;
  for (const float v : voxels) count += is_beyond(v) ? 1 : 0;
  if (count == 0) return;
  clipped.limit = last * coding.scale + std::abs(coding.offset);
  for (const float v : voxels) {
    if (!is_beyond(v) || std::isinf(v)) continue;
    ++clipped.count;
    if (std::abs(v) > std::abs(clipped.farthest)) clipped.farthest = v;
  }
}

void add_clipped(const ClippedVoxels& more, ClippedVoxels& clipped) {
  if (more.count == 0) return;
  clipped.count += more.count;
  clipped.limit = more.limit;
  if (std::abs(more.farthest) > std::abs(clipped.farthest)) clipped.farthest = more.farthest;
}

}  // namespace octavo
