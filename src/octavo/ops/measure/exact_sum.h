// Sums of floats and of their squares without any rounding, so that neither the order of the
// values nor the parts in which they were summed change a digit.
//
//     sum      = sum of digits_[i] * 2^(32 * i - 149)    149: the smallest float is 2^-149
//     squares  = sum of squares_[i] * 2^(32 * i - 298)
//
// Invariants
//   Every digit lies within 2^63: digits grow by less than 2^32 a value, and are carried on before
//   there are 2^30 values that were not.
// Source  U. Kulisch, W. Miranker, The arithmetic of the digital computer, 1986 (long accumulators)
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace octavo {

class ExactSum {
 public:
  static constexpr std::size_t kSumDigits = 11;      // 149 + 128 + 64 bits of a count, and a sign
  static constexpr std::size_t kSquareDigits = 20;   // 298 + 256 + 64, and a sign
  using SumDigits = std::array<std::int64_t, kSumDigits>;
  using SquareDigits = std::array<std::int64_t, kSquareDigits>;

  ExactSum() = default;
  /// Requires digits as normal_sum and normal_squares give them.
  ExactSum(const SumDigits& sum, const SquareDigits& squares) : sum_(sum), squares_(squares) {}

  /// Requires a finite value.
  void add(float value);
  void add(const ExactSum& other);

  /// The sum, rounded once.
  long double sum() const;
  /// The sum of the squares of the distances from the mean of `count` values, times `count`:
  /// computed without rounding, and rounded once.
  long double squared_distances(std::uint64_t count) const;

  /// All digits but the last in [0, 2^32): equal sums have equal digits.
  SumDigits normal_sum() const;
  SquareDigits normal_squares() const;

 private:
  void carry();

  SumDigits sum_{};
  SquareDigits squares_{};
  std::uint32_t uncarried_ = 0;  ///< values since digits were carried on
};

}  // namespace octavo
