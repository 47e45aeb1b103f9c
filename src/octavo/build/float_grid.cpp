#include "octavo/build/float_grid.h"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <limits>

namespace octavo {

namespace {

constexpr std::uint32_t kEmpty = 0x7fc00000;  // a NaN
constexpr std::size_t kSlots = 2 * DistinctValues::kMost;

// Codes stay far below the 2^24 steps that a float tells apart.
constexpr double kMostSteps = 1 << 20;
constexpr double kFloatRounding = 1.0 / (1 << 24);
constexpr std::size_t kEnoughForOffset = 64;
constexpr double kClearlyMore = 1.5;
constexpr double kLargestCode = std::numeric_limits<std::int32_t>::max();

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

double rounded(double value, int digits) {
  char text[40];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::scientific,
                                 digits - 1);
  double result = value;
  std::from_chars(text, end.ptr, result);
  return result;
}

// The scales between two bounds, the likeliest first.
std::vector<double> likely_scales(double low, double high) {
  constexpr int kFewDigits = 5;
  constexpr int kAllDigits = 17;
  const double middle = low + (high - low) / 2;
  std::vector<double> scales;
  const auto offer = [&](double scale) {
    if (scale >= low && scale <= high) scales.push_back(scale);
  };
  for (int digits = 1; digits <= kFewDigits; ++digits) offer(rounded(middle, digits));
  offer(1 / std::round(1 / middle));
  offer(static_cast<double>(static_cast<float>(middle)));
  for (int digits = kFewDigits + 1; digits <= kAllDigits; ++digits) offer(rounded(middle, digits));
  offer(middle);
  return scales;
}

// value = code * scale: the steps from 0, then the scales that give all bits back.
std::optional<SampleCoding> multiples(std::span<const float> values) {
  std::vector<Measured> distances;
  for (const float v : values) {
    const double d = std::abs(static_cast<double>(v));
    if (d != 0) distances.push_back({d, rounding_of(d)});
  }
  std::sort(distances.begin(), distances.end(),
            [](const Measured& a, const Measured& b) { return a.value < b.value; });
  const double step = step_of(distances);
  if (step == 0) return std::nullopt;

  // A value stands for all numbers that round to it; divided by its code they bound the scale.
  double low = 0;
  double high = std::numeric_limits<double>::infinity();
  for (const auto& [d, error] : distances) {
    const auto v = static_cast<float>(d);
    const double code = std::round(d / step);
    const double below = std::nextafter(v, 0.0f);
    const double above = std::nextafter(v, std::numeric_limits<float>::infinity());
    low = std::max(low, (d + below) / 2 / code);
    if (std::isfinite(above)) high = std::min(high, (d + above) / 2 / code);
  }
  if (!(low <= high) || !std::isfinite(high)) return std::nullopt;
  for (const double scale : likely_scales(low, high)) {
    const SampleCoding coding{VoxelType::int32, scale, 0};
    if (holds_all(coding, values)) return coding;
  }
  return std::nullopt;
}

struct Line {
  double slope;
  double intercept;
};

// Least squares through (code, value).
Line fit(std::span<const float> values, double step) {
  const auto n = static_cast<double>(values.size());
  const double first = values.front();
  double mean_code = 0;
  double mean_value = 0;
  for (const float v : values) {
    mean_code += std::round((v - first) / step) / n;
    mean_value += (v - first) / n;
  }
  double covariance = 0;
  double variance = 0;
  for (const float v : values) {
    const double code = std::round((v - first) / step) - mean_code;
    covariance += code * (v - first - mean_value);
    variance += code * code;
  }
  const double slope = covariance / variance;
  return {slope, first + mean_value - slope * mean_code};
}

// value = code * scale + offset, where both have few digits.
std::optional<SampleCoding> shifted_multiples(std::span<const float> values) {
  constexpr std::size_t kFewest = 3;
  constexpr int kScaleDigits = 7;
  constexpr int kDecimals = 9;
  if (values.size() < kFewest) return std::nullopt;
  const double first = values.front();
  const double largest = std::max(std::abs(first), std::abs(static_cast<double>(values.back())));
  std::vector<Measured> distances;
  const double error = 2 * rounding_of(largest);
  for (const float v : values.subspan(1)) distances.push_back({v - first, error});
  const double step = step_of(distances);
  if (step == 0) return std::nullopt;

  const Line line = fit(values, step);
  for (int digits = 1; digits <= kScaleDigits; ++digits) {
    const double scale = rounded(line.slope, digits);
    if (!(scale > 0)) continue;
    const double offset = line.intercept - std::round(line.intercept / scale) * scale;
    for (int decimals = 0; decimals <= kDecimals; ++decimals) {
      const double unit = std::pow(10.0, decimals);
      const SampleCoding coding{VoxelType::int32, scale, std::round(offset * unit) / unit};
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
    hint.type = VoxelType::int32;
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
