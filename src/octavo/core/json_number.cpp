#include "octavo/core/json_number.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "octavo/core/powers_of_ten.h"

namespace octavo {

namespace {

/// significand * 2^exponent.
struct Binary {
  std::uint64_t significand = 0;
  int exponent = 0;
};

/// 0.DIGITS * 10^point.
struct Decimal {
  std::string digits;
  int point = 0;
};

/// A double and the middles between it and its neighbors, all with one exponent.
struct Neighborhood {
  Binary below;
  Binary value;
  Binary above;
};

constexpr int kFractionBits = 52;
constexpr int kSmallestExponent = -1074;  // of the last bit of a double
/// The products of a double and a power of ten have an exponent of at least this: then 32 bits hold
/// the whole part.
constexpr int kLowestExponent = -60;

Binary normalized(const Binary& number) {
  const int shift = std::countl_zero(number.significand);
  return {number.significand << shift, number.exponent - shift};
}

Binary with_exponent(const Binary& number, int exponent) {
  return {number.significand << (number.exponent - exponent), exponent};
}

/// Requires a finite value above 0.
Neighborhood neighborhood_of(double value) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  const std::uint64_t fraction = bits & ((std::uint64_t{1} << kFractionBits) - 1);
  const auto biased = static_cast<int>(bits >> kFractionBits);
  const bool is_subnormal = biased == 0;
  const std::uint64_t leading = is_subnormal ? 0 : std::uint64_t{1} << kFractionBits;
  const Binary exact = {fraction + leading, kSmallestExponent + std::max(biased, 1) - 1};
  // Below a power of two, doubles lie twice as close.
  const bool is_closer_below = fraction == 0 && biased > 1;
  const Binary above = normalized({2 * exact.significand + 1, exact.exponent - 1});
  const Binary below = is_closer_below ? Binary{4 * exact.significand - 1, exact.exponent - 2}
                                       : Binary{2 * exact.significand - 1, exact.exponent - 1};
  return {with_exponent(below, above.exponent), normalized(exact), above};
}

/// The upper 64 bits of the product, rounded.
Binary product(const Binary& a, const Binary& b) {
  const std::uint64_t mask = 0xffffffff;
  const std::uint64_t a_low = a.significand & mask, a_high = a.significand >> 32;
  const std::uint64_t b_low = b.significand & mask, b_high = b.significand >> 32;
  const std::uint64_t low_high = a_low * b_high;
  const std::uint64_t high_low = a_high * b_low;
  const std::uint64_t carried = (a_low * b_low >> 32) + (low_high & mask) + (high_low & mask) +
                                (std::uint64_t{1} << 31);
  return {a_high * b_high + (low_high >> 32) + (high_low >> 32) + (carried >> 32),
          a.exponent + b.exponent + 64};
}

/// The smallest power that lifts a number of this exponent to kLowestExponent.
const PowerOfTen& lifting_power(int exponent) {
  return *std::find_if(kPowersOfTen.begin(), kPowersOfTen.end(), [&](const PowerOfTen& power) {
    return power.binary + exponent + 64 >= kLowestExponent;
  });
}

/// Lowers the last digit while that brings the digits closer to the value.
/// to_value  from the digits' upper bound down to the value; width to the lower bound; rest to the
///           digits; unit is one of the last digit
void approach(std::string& digits, std::uint64_t to_value, std::uint64_t width, std::uint64_t rest,
              std::uint64_t unit) {
  while (rest < to_value && width - rest >= unit &&
         (rest + unit < to_value || to_value - rest > rest + unit - to_value)) {
    --digits.back();
    rest += unit;
  }
}

/// The fewest digits of a number between `below` and `above`, near `value`.
/// scale  what all three were multiplied by: 10^-scale
Decimal digits_between(const Binary& below, const Binary& value, const Binary& above, int scale) {
  const int fraction_bits = -above.exponent;
  const std::uint64_t one = std::uint64_t{1} << fraction_bits;
  std::uint64_t width = above.significand - below.significand;
  std::uint64_t to_value = above.significand - value.significand;
  auto whole = static_cast<std::uint32_t>(above.significand >> fraction_bits);
  std::uint64_t fraction = above.significand & (one - 1);
  std::uint32_t unit = 1;
  int left = 1;  // digits of the whole part that are still to come
  for (; whole / unit >= 10; unit *= 10) ++left;

  // Digits of the whole part.
  Decimal decimal;
  for (; left > 0; unit /= 10) {
    decimal.digits += static_cast<char>('0' + whole / unit);
    whole %= unit;
    --left;
    const std::uint64_t rest = (std::uint64_t{whole} << fraction_bits) + fraction;
    if (rest > width) continue;
    approach(decimal.digits, to_value, width, rest, std::uint64_t{unit} << fraction_bits);
    decimal.point = static_cast<int>(decimal.digits.size()) + left + scale;
    return decimal;
  }

  // Digits behind the point.
  int behind = 0;
  do {
    fraction *= 10;
    width *= 10;
    to_value *= 10;
    decimal.digits += static_cast<char>('0' + (fraction >> fraction_bits));
    fraction &= one - 1;
    ++behind;
  } while (fraction > width);
  approach(decimal.digits, to_value, width, fraction, one);
  decimal.point = static_cast<int>(decimal.digits.size()) - behind + scale;
  return decimal;
}

Decimal decimal_of(double value) {
  const Neighborhood near = neighborhood_of(value);
  const PowerOfTen& power = lifting_power(near.above.exponent);
  const Binary factor = {power.significand, power.binary};
  Binary below = product(near.below, factor);
  Binary above = product(near.above, factor);
  // The products may be off by one.
  ++below.significand;
  --above.significand;
  return digits_between(below, product(near.value, factor), above, -power.decimal);
}

std::string exponent_text(int exponent) {
  const std::string digits = std::to_string(std::abs(exponent));
  return (exponent < 0 ? "e-" : "e+") + std::string(digits.size() < 2 ? "0" : "") + digits;
}

std::string text_of(const Decimal& decimal) {
  constexpr int kFewestPlaces = -4;
  constexpr int kMostPlaces = 15;
  const auto& [digits, point] = decimal;
  const auto count = static_cast<int>(digits.size());
  if (point > kMostPlaces || point <= kFewestPlaces) {
    const std::string rest = digits.substr(1);
    return digits.substr(0, 1) + (rest.empty() ? "" : "." + rest) + exponent_text(point - 1);
  }
  if (point <= 0) return "0." + std::string(static_cast<std::size_t>(-point), '0') + digits;
  if (count <= point) {
    return digits + std::string(static_cast<std::size_t>(point - count), '0') + ".0";
  }
  const auto at = static_cast<std::size_t>(point);
  return digits.substr(0, at) + "." + digits.substr(at);
}

}  // namespace

std::string json_number(double value) {
  if (!std::isfinite(value)) return "null";
  const std::string sign = std::signbit(value) ? "-" : "";
  return sign + (value == 0 ? "0.0" : text_of(decimal_of(std::abs(value))));
}

}  // namespace octavo
