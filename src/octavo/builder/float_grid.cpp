#include "octavo/builder/float_grid.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace octavo {

namespace {

constexpr auto kEmpty = std::bit_cast<std::uint32_t>(std::numeric_limits<float>::quiet_NaN());
constexpr std::size_t kSlots = 2 * DistinctValues::kMost;

// Codes stay far below the 2^24 steps that a float tells apart.
constexpr double kMostSteps = 1 << 20;
constexpr double kFloatRounding = 1.0 / (1 << 24);
constexpr std::size_t kEnoughForOffset = 64;
constexpr double kClearlyMore = 1.5;

bool holds_all(const SampleCoding& coding, std::span<const float> values) {
  return is_valid(coding) && std::all_of(values.begin(), values.end(), [&](float v) {
           return exact_code(coding, v).has_value();
         });
}

// How far a float may lie from the number it was rounded from.
double rounding_of(double value) {
  return std::max(value * kFloatRounding,
                  static_cast<double>(std::numeric_limits<float>::denorm_min()) / 2);
}

// A number that is known to +-error.
struct Measured {
  double value = 0;
  double error = 0;
};

// The greatest common divisor of two positive numbers, or nothing when it drowns in their errors.
std::optional<Measured> common_step(Measured a, Measured b) {
  for (;;) {
    const double quotient = std::floor(a.value / b.value);
    const Measured rest{a.value - quotient * b.value, a.error + quotient * b.error};
    if (4 * rest.error > b.value) return std::nullopt;
    if (rest.value <= 2 * rest.error || b.value - rest.value <= 2 * rest.error) return b;
    a = b;
    b = rest;
  }
}

// The step that all distances (ascending, positive) are multiples of; 0 when there is none.
double step_of(std::span<const Measured> distances) {
  if (distances.empty()) return 0;
  Measured step = distances.front();
  for (const Measured& d : distances) {
    const auto common = common_step(d, step);
    if (!common) continue;
    step = *common;
    if (distances.back().value > kMostSteps * step.value) return 0;
    // The more steps a distance has, the better it tells how long one is.
    const double count = std::round(d.value / step.value);
    if (4 * count * step.error < step.value && d.error / count < step.error) {
      step = {d.value / count, d.error / count};
    }
  }
  return step.value;
}

// The step between values: the short distances, those to the next value, tell what it is, the long
// ones how long it is.
// values     ascending, different
// distances  further ones, positive
double step_between(std::span<const float> values, std::vector<Measured> distances) {
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double a = values[i - 1];
    const double b = values[i];
    distances.push_back({b - a, rounding_of(std::abs(a)) + rounding_of(std::abs(b))});
  }
  std::sort(distances.begin(), distances.end(),
            [](const Measured& a, const Measured& b) { return a.value < b.value; });
  return step_of(distances);
}

double rounded(double value, int digits) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific,
                                 digits - 1);
  double result = value;
  std::from_chars(text, end.ptr, result);
  return result;
}

struct Interval {
  double low;
  double high;
  double middle() const { return low + (high - low) / 2; }
  bool contains(double value) const { return value >= low && value <= high; }
};

struct Fraction {
  double numerator;
  double denominator;
};

// The fraction with the smallest denominator between two positive bounds (Stern-Brocot).
Fraction simplest_fraction(Interval between, int depth = 40) {
  const double whole = std::floor(between.low);
  if (between.low == whole) return {whole, 1};
  if (whole + 1 <= between.high || depth == 0) return {whole + 1, 1};
  const Fraction rest = simplest_fraction(
      {1 / (between.high - whole), 1 / (between.low - whole)}, depth - 1);
  return {whole * rest.numerator + rest.denominator, rest.numerator};
}

// Numbers between two positive bounds, those that people and headers would write first.
std::vector<double> likely_numbers(const Interval& between) {
  constexpr int kFewDigits = 5;
  constexpr int kAllDigits = 17;
  constexpr double kChance = 1e-3;
  const double middle = between.middle();
  std::vector<double> numbers;
  const auto offer = [&](double number) {
    if (between.contains(number)) numbers.push_back(number);
  };
  for (int digits = 1; digits <= kFewDigits; ++digits) offer(rounded(middle, digits));
  // Between any two numbers lies some fraction; a simple one between close bounds is no chance.
  const Fraction fraction = simplest_fraction(between);
  const double width = (between.high - between.low) / middle;
  if (fraction.numerator * fraction.denominator * width < kChance) {
    offer(fraction.numerator / fraction.denominator);
  }
  offer(static_cast<double>(static_cast<float>(middle)));
  for (int digits = kFewDigits + 1; digits <= kAllDigits; ++digits) offer(rounded(middle, digits));
  offer(middle);
  return numbers;
}

// The numbers that round to a float.
Interval preimage_of(float v) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const double value = v;
  const double below = std::nextafter(v, -kInfinity);
  const double above = std::nextafter(v, kInfinity);
  return {std::isfinite(below) ? (value + below) / 2 : value,
          std::isfinite(above) ? (value + above) / 2 : value};
}

// value = code * scale: the steps from 0, then the scales that give all bits back.
std::optional<SampleCoding> multiples(std::span<const float> values) {
  std::vector<Measured> distances;
  for (const float v : values) {
    const double d = std::abs(static_cast<double>(v));
    if (d != 0) distances.push_back({d, rounding_of(d)});
  }
  const double step = step_between(values, distances);
  if (step == 0) return std::nullopt;

  // A value stands for all numbers that round to it; divided by its code they bound the scale.
  Interval scales{0, std::numeric_limits<double>::infinity()};
  for (const Measured& d : distances) {
    const double code = std::round(d.value / step);
    const Interval numbers = preimage_of(static_cast<float>(d.value));
    scales = {std::max(scales.low, numbers.low / code), std::min(scales.high, numbers.high / code)};
  }
  if (!(scales.low <= scales.high) || !(scales.low > 0)) return std::nullopt;
  for (const double scale : likely_numbers(scales)) {
    const SampleCoding coding{VoxelType::int32, scale, 0};
    if (holds_all(coding, values)) return coding;
  }
  return std::nullopt;
}

// Values with their codes, of which a line value = code * scale + offset shall pass all.
struct CodedValue {
  double code;
  Interval numbers;
};

// The offsets with which a scale passes all values; low > high when there is none.
Interval offsets_of(const std::vector<CodedValue>& values, double scale) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Interval offsets{-kInfinity, kInfinity};
  for (const CodedValue& v : values) {
    offsets.low = std::max(offsets.low, v.numbers.low - v.code * scale);
    offsets.high = std::min(offsets.high, v.numbers.high - v.code * scale);
  }
  return offsets;
}

// The scales that pass all values with some offset. The room for offsets is a concave function of
// the scale: its peak is searched, then where it ends on both sides.
std::optional<Interval> scales_of(const std::vector<CodedValue>& values, double step) {
  constexpr double kAround = 1e-3;
  constexpr int kHalvings = 100;
  const auto room = [&](double scale) {
    const Interval offsets = offsets_of(values, scale);
    return offsets.high - offsets.low;
  };
  Interval search{step * (1 - kAround), step * (1 + kAround)};
  for (int i = 0; i < kHalvings; ++i) {
    const double third = (search.high - search.low) / 3;
    if (room(search.low + third) < room(search.high - third)) search.low += third;
    else search.high -= third;
  }
  const double peak = search.middle();
  if (room(peak) < 0) return std::nullopt;
  const auto edge = [&](double inside, double outside) {
    for (int i = 0; i < kHalvings; ++i) {
      const double middle = inside + (outside - inside) / 2;
      (room(middle) >= 0 ? inside : outside) = middle;
    }
    return inside;
  };
  return Interval{edge(peak, step * (1 - kAround)), edge(peak, step * (1 + kAround))};
}

// An offset that people would write, of those that differ by whole scales from an interval's.
std::vector<double> likely_offsets(const Interval& offsets, double scale) {
  constexpr int kDecimals = 9;
  const double shift = std::round(offsets.middle() / scale) * scale;
  const Interval near{offsets.low - shift, offsets.high - shift};
  std::vector<double> numbers;
  for (int decimals = 0; decimals <= kDecimals; ++decimals) {
    const double unit = std::pow(10.0, decimals);
    const double offset = std::round(near.middle() * unit) / unit;
    if (near.contains(offset)) numbers.push_back(offset);
  }
  numbers.push_back(near.middle());
  numbers.push_back(offsets.middle());
  return numbers;
}

// value = code * scale + offset: the steps between values, then a line through all of them.
std::optional<SampleCoding> shifted_multiples(std::span<const float> values) {
  constexpr std::size_t kFewest = 3;
  constexpr std::size_t kMostOnLine = 4096;
  if (values.size() < kFewest) return std::nullopt;
  const double first = values.front();
  const double largest = std::max(std::abs(first), std::abs(static_cast<double>(values.back())));
  std::vector<Measured> distances;
  const double error = 2 * rounding_of(largest);
  for (const float v : values.subspan(1)) distances.push_back({v - first, error});
  const double step = step_between(values, distances);
  if (step == 0) return std::nullopt;

  std::vector<CodedValue> coded;
  const std::size_t stride = values.size() / kMostOnLine + 1;
  for (std::size_t i = 0; i < values.size(); i += stride) {
    coded.push_back({std::round((values[i] - first) / step), preimage_of(values[i])});
  }
  const auto scales = scales_of(coded, step);
  if (!scales) return std::nullopt;
  for (const double scale : likely_numbers(*scales)) {
    for (const double offset : likely_offsets(offsets_of(coded, scale), scale)) {
      const SampleCoding coding{VoxelType::int32, scale, offset};
      if (holds_all(coding, values)) return coding;
    }
  }
  return std::nullopt;
}

// value = code * 2^n: the lowest bit that any value has.
std::optional<SampleCoding> binary_multiples(std::span<const float> values) {
  int lowest = std::numeric_limits<int>::max();
  for (const float v : values) {
    if (v == 0) continue;
    int exponent = 0;
    const float fraction = std::abs(std::frexp(v, &exponent));
    const auto mantissa = static_cast<std::uint32_t>(fraction * (1 << 24));
    lowest = std::min(lowest, exponent - 24 + std::countr_zero(mantissa));
  }
  if (lowest == std::numeric_limits<int>::max()) lowest = 0;
  const SampleCoding coding{VoxelType::int32, std::ldexp(1.0, lowest), 0};
  return holds_all(coding, values) ? std::optional(coding) : std::nullopt;
}

}  // namespace

DistinctValues::DistinctValues() : slots_(kSlots, kEmpty) {}

void DistinctValues::add(std::span<const float> values) {
  std::uint32_t previous = kEmpty;
  for (const float v : values) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(v == 0 ? 0.0f : v);
    if (bits == previous || !std::isfinite(v)) continue;
    previous = bits;
    std::size_t slot = (bits * 2654435769u) >> 13;  // of kSlots = 2^19
    while (slots_[slot] != kEmpty && slots_[slot] != bits) slot = (slot + 1) % kSlots;
    if (slots_[slot] == bits || count_ == kMost) continue;
    slots_[slot] = bits;
    ++count_;
  }
}

std::vector<float> DistinctValues::sorted() const {
  std::vector<float> values;
  for (const std::uint32_t bits : slots_) {
    if (bits != kEmpty) values.push_back(std::bit_cast<float>(bits));
  }
  std::sort(values.begin(), values.end());
  return values;
}

std::optional<std::int64_t> exact_code(const SampleCoding& coding, float voxel) {
  const double steps = (static_cast<double>(voxel) - coding.offset) / coding.scale;
  if (!(std::abs(steps) < kLargestCode)) return std::nullopt;
  const auto code = static_cast<std::int64_t>(std::nearbyint(steps));
  const bool is_same =
      std::bit_cast<std::uint32_t>(coding.voxel_of(code)) == std::bit_cast<std::uint32_t>(voxel);
  return is_same ? std::optional(code) : std::nullopt;
}

std::optional<SampleCoding> find_coding(std::span<const float> values,
                                        std::span<const SampleCoding> hints) {
  for (SampleCoding hint : hints) {
    hint = {VoxelType::int32, hint.scale, hint.offset};
    if (holds_all(hint, values)) return hint;
  }
  const auto plain = multiples(values);
  // An offset is one more number to be wrong by chance: few values do without it.
  const auto shifted =
      plain && values.size() < kEnoughForOffset ? std::nullopt : shifted_multiples(values);
  if (shifted && (!plain || shifted->scale > kClearlyMore * plain->scale)) return shifted;
  return plain ? plain : binary_multiples(values);
}

}  // namespace octavo
