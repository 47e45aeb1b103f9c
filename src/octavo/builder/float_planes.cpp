#include "octavo/builder/float_planes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <optional>

#include "octavo/builder/float_grid.h"
#include "octavo/builder/float_trial.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

// Of more different values none comes often enough that rounding would cost more than it saves.
constexpr std::size_t kFewValues = std::size_t{1} << 16;
constexpr std::size_t kEnoughVoxels = 1024;
// A coding seen in fewer values than this may be chance: a max error then does without it.
constexpr std::size_t kEnoughValues = 64;
constexpr double kStepsPerError = 32;
constexpr double kFloatSteps = 1 << 24;
constexpr double kMinError = 1e-290;
constexpr double kMedianOfDifference = 0.954;  // of two normal numbers of deviation 1
// Values yet to come may be so much larger than those of the first planes.
constexpr double kGrowth = 4;

std::string text_of(double value, int digits = 9) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string text_of(float value) { return text_of(static_cast<double>(value)); }

void repair_voxels(std::span<float> voxels, const FloatRepair& repair) {
  for (float& v : voxels) {
    if (std::isfinite(v)) continue;
    if (std::isnan(v) && repair.nan) v = *repair.nan;
    if (std::isinf(v) && repair.infinity) v = std::copysign(1.0f, v) * *repair.infinity;
  }
}

bool is_finite(std::span<const float> voxels) {
  // A sum of zeros unless one is not finite; no branch in the loop.
  float sum = 0;
  for (const float v : voxels) sum += v * 0.0f;
  return sum == 0;
}

bool is_constant(std::span<const float> voxels) {
  return std::memcmp(voxels.data(), voxels.data() + 1, (voxels.size() - 1) * sizeof(float)) == 0;
}

// Rounded to the nearest integer, ties to even. Requires |value| < 2^51.
double to_integer(double value) {
  constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52
  return value + kShift - kShift;
}

class RepairedSource final : public PlaneSource {
 public:
  RepairedSource(PlaneSource& source, const FloatRepair& repair)
      : source_(source), repair_(repair) {}
  const VolumeDescription& description() const override { return source_.description(); }
  const std::vector<Warning>& warnings() const override { return source_.warnings(); }
  std::uint64_t resident_bytes() const override { return source_.resident_bytes(); }
  const PlaneFiles& files() const override { return source_.files(); }

  void read_plane(std::span<std::byte> plane) override {
    source_.read_plane(plane);
    if (is_integer(description().type)) return;
    voxels_.resize(plane.size() / sizeof(float));
    std::memcpy(voxels_.data(), plane.data(), plane.size());
    repair_voxels(voxels_, repair_);
    std::memcpy(plane.data(), voxels_.data(), plane.size());
  }

  bool can_seek() const override { return source_.can_seek(); }
  void seek(std::int64_t first, std::int64_t end) override { source_.seek(first, end); }

 private:
  PlaneSource& source_;
  FloatRepair repair_;
  std::vector<float> voxels_;
};

// Whether many of the values have floats beside them that are no multiples.
bool is_coarser_than_floats(const SampleCoding& coding, std::span<const float> values) {
  constexpr std::ptrdiff_t kMany = 16;  // one of so many
  const auto count = std::ranges::count_if(values, [&](float v) {
    return v != 0 && std::ldexp(1.0, std::ilogb(v) - 23) < coding.scale;
  });
  return count * kMany > static_cast<std::ptrdiff_t>(values.size());
}

// The magnitude of the largest value that is not far beyond nearly all others. Each value counts
// once, however many voxels hold it, as the fill value of a background does.
double bulk_of(const std::vector<float>& values) {
  constexpr double kFar = 1 << 10;
  constexpr std::size_t kFew = 64;  // one of so many values may lie far away
  if (values.empty()) return 0;
  std::vector<double> magnitudes;
  for (const float v : values) magnitudes.push_back(std::abs(static_cast<double>(v)));
  std::sort(magnitudes.begin(), magnitudes.end());
  const std::size_t far = (magnitudes.size() + kFew - 1) / kFew;
  if (far >= magnitudes.size()) return magnitudes.back();
  const double usual = magnitudes[magnitudes.size() - 1 - far];
  if (usual == 0) return magnitudes.back();
  return *(std::upper_bound(magnitudes.begin(), magnitudes.end(), usual * kFar) - 1);
}

using Planes = std::deque<std::vector<float>>;

// The floats that many voxels of some planes are, as the fill values of a background.
std::vector<float> frequent_values(const Planes& planes) {
  constexpr std::size_t kMany = 16;  // one of so many voxels
  constexpr std::size_t kSamples = 1 << 16;
  std::size_t count = 0;
  for (const std::vector<float>& plane : planes) count += plane.size();
  const std::size_t stride = count / kSamples + 1;
  std::vector<float> samples;
  for (const std::vector<float>& plane : planes) {
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
  void start() { before_.reset(); }
  void add(double value) {
    if (before_ && value != *before_ && differences_.size() < kMost) {
      differences_.push_back(std::abs(value - *before_));
    }
    before_ = value;
  }
  const std::vector<double>& all() const { return differences_; }

 private:
  static constexpr std::size_t kMost = 1 << 20;
  std::vector<double> differences_;
  std::optional<double> before_;
};

// Differences that tell of noise: between neighbors of which neither is a frequent value; where
// these are rare, between voxels with frequent ones between them, or between all.
std::vector<double> differences_between(const Planes& planes, double bulk) {
  constexpr std::size_t kEnough = 16;
  const std::vector<float> frequent = frequent_values(planes);
  Differences beside;
  Differences behind;
  Differences of_all;
  for (const std::vector<float>& plane : planes) {
    beside.start();
    of_all.start();
    for (const float voxel : plane) {
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
  if (rare.size() >= kEnoughValues) offer(std::move(rare));
  return choices;
}

// Numbers that the source's header would have multiplied its integers by.
std::vector<SampleCoding> hints_of(const VolumeDescription& source) {
  std::vector<SampleCoding> hints;
  if (source.coding) hints.push_back(*source.coding);
  hints.push_back({VoxelType::int32, 1, 0});
  const Rescale& rescale = source.rescale;
  if (!rescale.is_identity()) {
    hints.push_back({VoxelType::int32, std::abs(rescale.slope), rescale.intercept});
    hints.push_back({VoxelType::int32, std::abs(rescale.slope), 0});
  }
  return hints;
}

}  // namespace

std::unique_ptr<PlaneSource> make_repaired_source(PlaneSource& source, const FloatRepair& repair) {
  return std::make_unique<RepairedSource>(source, repair);
}

FloatPlanes::FloatPlanes(PlaneSource& source, const FloatSettings& settings, Progress& progress)
    : FloatPlanes(source, settings, progress, nullptr) {}

FloatPlanes::FloatPlanes(PlaneSource& source, const FloatSettings& settings,
                         const FloatChoice& known, Progress& progress)
    : FloatPlanes(source, settings, progress, &known) {}

FloatPlanes::FloatPlanes(PlaneSource& source, const FloatSettings& settings, Progress& progress,
                         const FloatChoice* known)
    : source_(source),
      settings_(settings),
      takes_all_(settings.max_error == 0),
      progress_(progress),
      description_(source.description()),
      cursor_(description_.size.z),
      plane_(static_cast<std::size_t>(description_.size.x * description_.size.y)) {
  if (settings.max_error > 0 && settings.max_error < kMinError) {
    throw Error(ErrorKind::invalid_argument, "a max error above 0 must be at least 1e-290");
  }
  if (!is_exact()) description_.type = VoxelType::int32;
  description_.coding.reset();
  if (known == nullptr) {
    read_ahead();
    return;
  }
  coding_ = known->coding;
  codec_error_ = known->codec_error;
  rounding_ = known->rounding;
  roomier_error_ = known->roomier_error;
  slack_ = known->slack;
  if (coding_.is_exact) keep_bits();
}

// Gives the floats as they are, whatever max error was asked for.
void FloatPlanes::keep_bits() {
  settings_.max_error = 0;
  codec_error_ = 0;
  description_.type = VoxelType::float32;
}

// Reads planes until enough of them are not constant, and chooses the coding.
void FloatPlanes::read_ahead() {
  DistinctValues distinct;
  std::int64_t telling = 0;
  while (telling < settings_.first_planes && planes_read_ < description_.size.z) {
    next_voxels();
    distinct.add(plane_);
    const bool is_alike = is_constant(plane_);
    if (!is_alike) ++telling;
    ahead_.push_back(is_alike ? std::vector<float>(1, plane_.front()) : plane_);
  }
  const std::vector<float> values = distinct.sorted();
  if (is_exact()) choose_exact(values);
  else if (!take_exact(values)) choose_within(values);
}

// Takes the floats bit by bit where that needs fewer bytes than the max error.
bool FloatPlanes::take_exact(const std::vector<float>& values) {
  std::size_t voxels = 0;
  for (const std::vector<float>& plane : ahead_) voxels += plane.size();
  if (values.size() > kFewValues || voxels < kEnoughVoxels) return false;
  choose_within(values);
  const SampleCoding within = coding_;
  const double limit = kLargestCode - static_cast<double>(codec_error_);
  const bool have_codes = std::ranges::all_of(values, [&](float v) {
    return std::abs((static_cast<double>(v) - within.offset) / within.scale) < limit;
  });
  choose_exact(values);
  const FloatStack stack{ahead_, description_.size.x, description_.size.y};
  if (!have_codes || !is_smaller_exact(stack, coding_, within, codec_error_)) return false;
  keep_bits();
  return true;
}

void FloatPlanes::choose_exact(const std::vector<float>& values) {
  constexpr double kMuchFiner = 32;
  const double bulk = bulk_of(values);
  const std::vector<SampleCoding> hints = hints_of(source_.description());
  const double step = noise_step(bulk);
  coding_ = {VoxelType::int32, step, 0};
  for (const std::vector<float>& some : likely_multiples(values, bulk, frequent_values(ahead_))) {
    const auto coding = find_coding(some, hints);
    // Steps far below the noise save nothing unless floats lie closer than they do.
    if (coding &&
        (coding->scale * kMuchFiner > step || is_coarser_than_floats(*coding, some))) {
      coding_ = *coding;
      break;
    }
  }
  coding_.is_exact = true;
}

// A power of two that divides the noise into some steps: what is finer than a step no prediction
// would save, and bins between powers of two then hold as many floats.
double FloatPlanes::noise_step(double bulk) const {
  constexpr int kSmallest = -148;  // half of it is a float
  constexpr double kStepsOfBulk = 1 << 20;
  constexpr double kStepsOfNoise = 8;
  std::vector<double> differences = differences_between(ahead_, bulk);
  double noise = 0;
  if (!differences.empty()) {
    const auto middle =
        differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
    std::nth_element(differences.begin(), middle, differences.end());
    noise = *middle / kMedianOfDifference;
  }
  int exponent = 0;
  std::frexp(std::max(noise / kStepsOfNoise, bulk / kStepsOfBulk), &exponent);
  return std::ldexp(1.0, std::max(exponent - 1, kSmallest));
}

// Takes a coding when the max error leaves room for its roundings.
bool FloatPlanes::choose_step(const SampleCoding& coding, double largest) {
  const double e = settings_.max_error;
  // So fine a scale has nothing to offer, and would bound the values yet to come.
  if (coding.scale * 2 * kStepsPerError < e) return false;
  int exponent = 0;
  const bool is_binary = std::frexp(coding.scale, &exponent) == 0.5 && coding.offset == 0;
  const double reach = kGrowth * (largest + e);
  // Half a float step at the largest value, on both sides of a difference.
  const double rounding =
      is_binary && reach < kFloatSteps * coding.scale ? 0 : reach / kFloatSteps;
  const double steps = std::floor((e - rounding) / coding.scale);
  if (!(steps >= 0) || largest / coding.scale > kLargestCode / 2) return false;
  coding_ = coding;
  codec_error_ = static_cast<std::int64_t>(steps);
  roomier_error_ = (steps + 0.9) * coding.scale;
  slack_ = e;
  if (codec_error_ == 0) return true;
  rounding_ = rounding;
  slack_ = std::max(0.0, e - rounding - steps * coding.scale);
  return true;
}

void FloatPlanes::choose_within(std::span<const float> values) {
  const double e = settings_.max_error;
  const double largest = values.empty() ? 0
                                        : std::max(std::abs(static_cast<double>(values.front())),
                                                   std::abs(static_cast<double>(values.back())));
  if (values.size() >= kEnoughValues) {
    const auto coding = find_coding(values, hints_of(source_.description()));
    if (coding && choose_step(*coding, largest)) return;
  }
  int exponent = 0;
  std::frexp(e / kStepsPerError, &exponent);
  coding_ = {VoxelType::int32, std::ldexp(1.0, exponent - 1), 0};
  // Half a step is left to the code itself; where floats are coarser than steps, only 31 steps are
  // sure to be rounded to at most 32.
  const bool has_room = kGrowth * (largest + e) < kFloatSteps * coding_.scale;
  codec_error_ = has_room ? static_cast<std::int64_t>(std::floor(e / coding_.scale - 0.5))
                          : static_cast<std::int64_t>(kStepsPerError) - 1;
  slack_ = e - static_cast<double>(codec_error_) * coding_.scale;
  // That many steps exactly: 31 of them are left to the codec whatever the values are.
  roomier_error_ = kStepsPerError * coding_.scale;
}

// The next plane of the source, repaired and proven finite.
void FloatPlanes::next_voxels() {
  if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
  source_.read_plane(std::as_writable_bytes(std::span(plane_)));
  const std::int64_t z = planes_read_++;
  if (is_finite(plane_)) return;
  repair_voxels(plane_, settings_.repair);
  if (!takes_all_ && !is_finite(plane_)) count_and_reject(z);
}

void FloatPlanes::count_and_reject(std::int64_t z) {
  const auto bad = std::find_if(plane_.begin(), plane_.end(), [](float v) {
    return !std::isfinite(v);
  });
  const std::int64_t at = bad - plane_.begin();
  const std::int64_t width = description_.size.x;
  const std::string first = text_of(*bad) + " at x,y,z = " + std::to_string(at % width) + "," +
                            std::to_string(at / width) + "," + std::to_string(z);
  std::int64_t nans = 0;
  std::int64_t infinities = 0;
  for (;;) {
    nans += std::count_if(plane_.begin(), plane_.end(), [](float v) { return std::isnan(v); });
    infinities +=
        std::count_if(plane_.begin(), plane_.end(), [](float v) { return std::isinf(v); });
    if (planes_read_ == cursor_.end()) break;
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
    source_.read_plane(std::as_writable_bytes(std::span(plane_)));
    ++planes_read_;
    repair_voxels(plane_, settings_.repair);
  }
  std::string what;
  if (nans > 0) what = std::to_string(nans) + " NaN";
  if (infinities > 0) {
    what += (what.empty() ? "" : " and ") + std::to_string(infinities) + " infinite";
  }
  const bool is_part = first_sought_ > 0 || cursor_.end() < description_.size.z;
  const std::string where = is_part ? " in planes " + std::to_string(first_sought_) + " to " +
                                          std::to_string(cursor_.end() - 1)
                                    : "";
  Error failure(ErrorKind::source_rejected,
                "holds " + what + " voxels" + where + ", the first " + first);
  if (nans > 0) failure = failure.with_field("repair.nan");
  if (infinities > 0) failure = failure.with_field("repair.infinity");
  throw failure;
}

void FloatPlanes::read_plane(std::span<std::byte> codes) {
  if (codes.size() != plane_.size() * sizeof(std::int32_t) ||
      cursor_.is_done()) {
    throw Error(ErrorKind::invalid_argument, "a plane of another size, or behind the last one");
  }
  if (ahead_.empty()) {
    next_voxels();
  } else if (ahead_.front().size() == 1) {
    std::fill(plane_.begin(), plane_.end(), ahead_.front().front());
  } else {
    plane_ = std::move(ahead_.front());
  }
  if (!ahead_.empty()) ahead_.pop_front();
  const std::int64_t z = cursor_.take();
  if (is_exact()) {
    std::memcpy(codes.data(), plane_.data(), codes.size());
    return;
  }
  const double limit = kLargestCode - static_cast<double>(codec_error_);
  for (std::size_t i = 0; i < plane_.size(); ++i) {
    const float v = plane_[i];
    const double steps = (static_cast<double>(v) - coding_.offset) / coding_.scale;
    if (!(std::abs(steps) < limit)) reject_voxel(z, i, true);
    const auto code = static_cast<std::int32_t>(to_integer(steps));
    const float back = coding_.voxel_of(code);
    const bool is_good = std::abs(static_cast<double>(back) - static_cast<double>(v)) <= slack_;
    if (!is_good) reject_voxel(z, i, false);
    std::memcpy(codes.data() + i * sizeof code, &code, sizeof code);
  }
}

void FloatPlanes::seek(std::int64_t first, std::int64_t end) {
  cursor_.seek(first, end);
  source_.seek(first, end);
  first_sought_ = first;
  ahead_.clear();
  planes_read_ = first;
}

void FloatPlanes::reject_voxel(std::int64_t z, std::size_t at, bool is_too_large) const {
  const float v = plane_[at];
  const std::int64_t width = description_.size.x;
  const std::string place = "plane " + std::to_string(z) + ": the voxel at x,y = " +
                            std::to_string(static_cast<std::int64_t>(at) % width) + "," +
                            std::to_string(static_cast<std::int64_t>(at) / width) + " is " +
                            text_of(v);
  const std::string steps = text_of(coding_.scale) +
                            (coding_.offset == 0 ? "" : " + " + text_of(coding_.offset));
  const double magnitude = std::abs(static_cast<double>(v));
  if (is_too_large) {
    const double enough = magnitude / (kLargestCode / 2) * kStepsPerError * 2;
    throw Error(ErrorKind::source_rejected, place + ", too large for so small a max error")
        .with_field("max_error", proposal(enough));
  }
  const double next_error = (static_cast<double>(codec_error_) + 0.5) * coding_.scale +
                            2 * rounding_ + 2 * (magnitude + coding_.scale) / kFloatSteps;
  throw Error(ErrorKind::source_rejected,
              place + ", no whole multiple of " + steps + " like the planes before")
      .with_field("max_error", proposal(next_error));
}

// `max_error` in voxel units; people give it in real ones.
std::string FloatPlanes::proposal(double max_error) const {
  const double real = max_error * std::abs(source_.description().rescale.slope);
  // Two digits, upwards, so that what is proposed is enough.
  const double unit = std::pow(10.0, std::floor(std::log10(real)) - 1);
  return text_of(std::ceil(real / unit - 1e-6) * unit, 2);
}

}  // namespace octavo
