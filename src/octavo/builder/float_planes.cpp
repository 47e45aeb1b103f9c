#include "octavo/builder/float_planes.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

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
  FloatStack& ahead = sample_.planes;
  ahead = FloatStack([this](std::size_t z, std::span<float> voxels) { read_again(z, voxels); });
  while (telling < settings_.first_planes && planes_read_ < description_.size.z) {
    next_voxels();
    distinct.add(plane_);
    const bool is_alike = is_constant(plane_);
    if (!is_alike) ++telling;
    if (is_alike) ahead.add({plane_.front()});
    else if (settings_.keeps_planes) ahead.add(plane_);
    else ahead.add_unkept(plane_.size());
  }
  sample_.first_values = distinct.sorted();
  sample_.values = sample_.first_values;
  look_further();
  if (is_exact()) choose_exact();
  else if (!take_exact()) choose_within(sample_.values);
  FloatSample used = std::exchange(sample_, {});
  if (settings_.keeps_planes) sample_.planes = std::move(used.planes);
  else seek(0, description_.size.z);
}

// A plane that was read before.
void FloatPlanes::read_again(std::size_t z, std::span<float> voxels) {
  if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
  const auto plane = static_cast<std::int64_t>(z);
  if (plane != next_again_) source_.seek(plane, planes_read_);
  source_.read_plane(std::as_writable_bytes(voxels));
  repair_voxels(voxels, settings_.repair);
  next_again_ = plane + 1;
}

// False where the plane cannot be read: that is an error once its turn comes, so that what is whole
// ahead of it can be kept.
bool FloatPlanes::reads_voxels_of(std::int64_t z) {
  try {
    source_.seek(z, z + 1);
    read_voxels();
    return true;
  } catch (const Error& error) {
    const bool is_of_plane = error.kind() == ErrorKind::source_rejected ||
                             error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::io ||
                             error.kind() == ErrorKind::truncated;
    if (!is_of_plane) throw;
    return false;
  }
}

// Looks at planes spread over those that were not read ahead, where these can be sought.
void FloatPlanes::look_further() {
  constexpr std::int64_t kMostPlanes = 64;
  constexpr std::int64_t kShare = 4;  // at most one of so many planes is read twice
  constexpr std::int64_t kVoxelsOfRows = 1 << 14;
  const std::int64_t left = description_.size.z - planes_read_;
  is_spread_ = left == 0 || source_.can_seek();
  if (left == 0 || !is_spread_) return;
  const std::int64_t count = std::min(kMostPlanes, (left + kShare - 1) / kShare);
  const std::int64_t width = description_.size.x;
  const std::int64_t row_count =
      std::clamp<std::int64_t>(kVoxelsOfRows / width, 1, description_.size.y);
  DistinctValues distinct;
  for (std::int64_t i = 0; i < count; ++i) {
    if (!reads_voxels_of(planes_read_ + left * (2 * i + 1) / (2 * count))) break;
    repair_voxels(plane_, settings_.repair);
    distinct.add(plane_);
    for (std::int64_t k = 0; k < row_count; ++k) {
      const std::int64_t y = description_.size.y * (2 * k + 1) / (2 * row_count);
      const auto row = plane_.begin() + y * width;
      sample_.rows.add({row, row + width});
    }
  }
  source_.seek(planes_read_, description_.size.z);
  const std::vector<float> further = distinct.sorted();
  sample_.values.clear();
  std::ranges::set_union(sample_.first_values, further, std::back_inserter(sample_.values));
}

// Takes the floats bit by bit where that needs fewer bytes than the max error.
bool FloatPlanes::take_exact() {
  const std::vector<float>& values = sample_.values;
  if (values.size() > kFewValues || sample_.planes.float_count() < kEnoughVoxels) return false;
  choose_within(values);
  const SampleCoding within = coding_;
  const double limit = kLargestCode - static_cast<double>(codec_error_);
  const bool have_codes = std::ranges::all_of(values, [&](float v) {
    return std::abs((static_cast<double>(v) - within.offset) / within.scale) < limit;
  });
  choose_exact();
  const TrialStack stack{sample_.planes, description_.size.x, description_.size.y};
  if (!have_codes || !is_smaller_exact(stack, coding_, within, codec_error_)) return false;
  keep_bits();
  return true;
}

void FloatPlanes::choose_exact() {
  coding_ = exact_coding_of(sample_, hints_of(source_.description()));
  const auto few = is_spread_ ? coding_of_few(sample_, coding_) : std::nullopt;
  const TrialStack stack{sample_.planes, description_.size.x, description_.size.y};
  // Two values are as a mask, however few of them some boxes hold.
  if (few && (sample_.values.size() == 2 || is_smaller_coding(stack, *few, coding_))) {
    coding_ = *few;
  }
  coding_ = with_steps_for_means(coding_, sample_.values);
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

void FloatPlanes::read_voxels() {
  if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped while reading planes");
  source_.read_plane(std::as_writable_bytes(std::span(plane_)));
}

// The next plane of the source, repaired and proven finite.
void FloatPlanes::next_voxels() {
  read_voxels();
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
  const std::string first = "at x,y,z = " + std::to_string(at % width) + "," +
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
                "holds " + what + (nans + infinities == 1 ? " voxel" : " voxels") + where +
                    (nans + infinities == 1 ? ", " : ", the first ") + first);
  if (nans > 0) failure = failure.with_field("repair.nan");
  if (infinities > 0) failure = failure.with_field("repair.infinity");
  throw failure;
}

void FloatPlanes::read_plane(std::span<std::byte> codes) {
  if (codes.size() != plane_.size() * sizeof(std::int32_t) ||
      cursor_.is_done()) {
    throw Error(ErrorKind::invalid_argument, "a plane of another size, or behind the last one");
  }
  if (sample_.planes.is_empty()) {
    next_voxels();
  } else {
    std::vector<float> ahead = sample_.planes.take_first();
    if (ahead.size() == 1) std::fill(plane_.begin(), plane_.end(), ahead.front());
    else plane_ = std::move(ahead);
  }
  const std::int64_t z = cursor_.take();
  if (is_exact()) {
    if (z >= counted_end_) count_clipped(coding_, plane_, clipped_);
    counted_end_ = std::max(counted_end_, z + 1);
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
  sample_.planes = {};
  planes_read_ = first;
}

// The largest magnitude in the plane that was read last and in all behind it.
double FloatPlanes::largest_left() {
  double largest = 0;
  const auto look_at = [&largest](std::span<const float> voxels) {
    for (const float v : voxels) {
      if (std::isfinite(v)) largest = std::max(largest, std::abs(static_cast<double>(v)));
    }
  };
  look_at(plane_);
  for (std::size_t i = 0; i < sample_.planes.count(); ++i) look_at(sample_.planes.plane(i));
  const std::vector<float> rejected = plane_;
  for (; planes_read_ < cursor_.end(); ++planes_read_) {
    read_voxels();
    repair_voxels(plane_, settings_.repair);
    look_at(plane_);
  }
  plane_ = rejected;
  return largest;
}

void FloatPlanes::reject_voxel(std::int64_t z, std::size_t at, bool is_too_large) {
  const float v = plane_[at];
  const std::int64_t width = description_.size.x;
  const std::string place = "plane " + std::to_string(z) + ": the voxel at x,y = " +
                            std::to_string(static_cast<std::int64_t>(at) % width) + "," +
                            std::to_string(static_cast<std::int64_t>(at) / width) + " is " +
                            text_of(v);
  const std::string steps = text_of(coding_.scale) +
                            (coding_.offset == 0 ? "" : " + " + text_of(coding_.offset));
  // What is proposed holds for all voxels, not for this one alone.
  const double magnitude = largest_left();
  const bool is_any_too_large =
      (magnitude + std::abs(coding_.offset)) / coding_.scale >=
      kLargestCode - static_cast<double>(codec_error_);
  const double enough = magnitude / (kLargestCode / 2) * kStepsPerError * 2;
  if (is_too_large) {
    throw Error(ErrorKind::source_rejected, place + ", too large for so small a max error")
        .with_field("max_error", proposal(enough));
  }
  const double next_error = (static_cast<double>(codec_error_) + 0.5) * coding_.scale +
                            2 * rounding_ + 2 * (magnitude + coding_.scale) / kFloatSteps;
  throw Error(ErrorKind::source_rejected,
              place + ", no whole multiple of " + steps + " like the planes before")
      .with_field("max_error",
                  proposal(is_any_too_large ? std::max(enough, next_error) : next_error));
}

// `max_error` in voxel units; people give it in real ones.
std::string FloatPlanes::proposal(double max_error) const {
  const double real = max_error * std::abs(source_.description().rescale.slope);
  // Two digits, upwards, so that what is proposed is enough.
  const double unit = std::pow(10.0, std::floor(std::log10(real)) - 1);
  return text_of(std::ceil(real / unit - 1e-6) * unit, 2);
}

}  // namespace octavo
