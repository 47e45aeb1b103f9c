#include "octavo/ops/measure/exact_sum.h"

#include <bit>
#include <cmath>
#include <span>

namespace octavo {

namespace {

constexpr int kDigitBits = 32;
constexpr std::int64_t kDigitMask = 0xffffffff;
constexpr std::uint32_t kMostUncarried = 1u << 30;
constexpr int kSmallest = -149;  // binary exponent of the smallest float

/// Adds `size` * 2^shift, or subtracts it.
void add_shifted(std::span<std::int64_t> digits, std::uint64_t size, int shift, bool is_negative) {
  auto at = static_cast<std::size_t>(shift / kDigitBits);
  auto rest = static_cast<unsigned __int128>(size) << shift % kDigitBits;
  for (; rest != 0; rest >>= kDigitBits, ++at) {
    const auto digit = static_cast<std::int64_t>(rest & kDigitMask);
    digits[at] += is_negative ? -digit : digit;
  }
}

/// Carries on from each digit to the next; the last one keeps the sign.
void carry_on(std::span<std::int64_t> digits) {
  for (std::size_t i = 0; i + 1 < digits.size(); ++i) {
    digits[i + 1] += digits[i] >> kDigitBits;
    digits[i] &= kDigitMask;
  }
}

/// Digits without a sign, all of them in [0, 2^32), and the sign.
template <std::size_t kCount>
struct Magnitude {
  std::array<std::uint32_t, kCount> digits{};
  bool is_negative = false;
};

template <std::size_t kCount>
Magnitude<kCount> magnitude_of(std::array<std::int64_t, kCount> digits) {
  carry_on(digits);
  Magnitude<kCount> result;
  result.is_negative = digits.back() < 0;
  if (result.is_negative) {
    for (std::int64_t& digit : digits) digit = -digit;
    carry_on(digits);
  }
  for (std::size_t i = 0; i < kCount; ++i) {
    result.digits[i] = static_cast<std::uint32_t>(digits[i]);
  }
  return result;
}

/// The number of these digits, of which the first counts 2^exponent: 64 bits from the highest on,
/// the last of which says whether anything follows, rounded to a long double.
long double rounded(std::span<const std::uint32_t> digits, int exponent) {
  std::size_t top = digits.size();
  while (top > 0 && digits[top - 1] == 0) --top;
  unsigned __int128 leading = 0;
  std::size_t taken = 0;
  while (taken < 3 && taken < top) leading = leading << kDigitBits | digits[top - 1 - taken++];
  bool has_more = false;
  for (std::size_t i = 0; i + taken < top; ++i) has_more = has_more || digits[i] != 0;
  if (has_more) leading |= 1;  // beyond the 65 bits that decide how to round
  const auto high = static_cast<std::uint64_t>(leading >> 64);
  const auto low = static_cast<std::uint64_t>(leading);
  const long double value = std::ldexp(static_cast<long double>(high), 64) +
                            static_cast<long double>(low);
  return std::ldexp(value, exponent + kDigitBits * static_cast<int>(top - taken));
}

/// a * b, of as many digits as both have together.
template <std::size_t kA, std::size_t kB>
std::array<std::uint32_t, kA + kB> product(const std::array<std::uint32_t, kA>& a,
                                           const std::array<std::uint32_t, kB>& b) {
  std::array<std::uint32_t, kA + kB> result{};
  for (std::size_t i = 0; i < kA; ++i) {
    std::uint64_t carried = 0;
    for (std::size_t j = 0; j < kB; ++j) {
      carried += static_cast<std::uint64_t>(a[i]) * b[j] + result[i + j];
      result[i + j] = static_cast<std::uint32_t>(carried);
      carried >>= kDigitBits;
    }
    result[i + kB] = static_cast<std::uint32_t>(carried);
  }
  return result;
}

}  // namespace

void ExactSum::add(float value) {
  if (uncarried_ == kMostUncarried) carry();
  ++uncarried_;
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const int exponent = static_cast<int>(bits >> 23 & 0xff);
  const std::uint64_t fraction = bits & 0x7fffff;
  const std::uint64_t whole = exponent == 0 ? fraction : fraction | 0x800000;
  const int shift = exponent == 0 ? 0 : exponent - 1;
  add_shifted(sum_, whole, shift, (bits >> 31) != 0);
  add_shifted(squares_, whole * whole, 2 * shift, false);
}

void ExactSum::add(const ExactSum& other) {
  carry();
  const SumDigits sum = other.normal_sum();
  const SquareDigits squares = other.normal_squares();
  for (std::size_t i = 0; i < kSumDigits; ++i) sum_[i] += sum[i];
  for (std::size_t i = 0; i < kSquareDigits; ++i) squares_[i] += squares[i];
  carry();
}

long double ExactSum::sum() const {
  const auto all = magnitude_of(sum_);
  const long double value = rounded(all.digits, kSmallest);
  return all.is_negative ? -value : value;
}

long double ExactSum::squared_distances(std::uint64_t count) const {
  // count * squares - sum^2, which is never negative
  const auto sum = magnitude_of(sum_).digits;
  const std::array<std::uint32_t, 2> factor = {static_cast<std::uint32_t>(count),
                                               static_cast<std::uint32_t>(count >> kDigitBits)};
  const auto all = product(magnitude_of(squares_).digits, factor);
  const auto mean = product(sum, sum);
  static_assert(all.size() == mean.size());
  std::array<std::int64_t, all.size()> distances;
  for (std::size_t i = 0; i < all.size(); ++i) {
    distances[i] = static_cast<std::int64_t>(all[i]) - static_cast<std::int64_t>(mean[i]);
  }
  return rounded(magnitude_of(distances).digits, 2 * kSmallest);
}

ExactSum::SumDigits ExactSum::normal_sum() const {
  SumDigits digits = sum_;
  carry_on(digits);
  return digits;
}

ExactSum::SquareDigits ExactSum::normal_squares() const {
  SquareDigits digits = squares_;
  carry_on(digits);
  return digits;
}

void ExactSum::carry() {
  carry_on(sum_);
  carry_on(squares_);
  uncarried_ = 0;
}

}  // namespace octavo
