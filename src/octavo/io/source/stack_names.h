// What the names of a stack of numbered files say of the order of its planes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace octavo {

/// Two names that follow each other in a stack, though they do not count on by one step.
struct NumberGap {
  std::size_t before = 0;     ///< index of the first of the two; the other follows it
  bool is_counted = true;     ///< false: no number counts from the one name to the other
  std::uint64_t missing = 0;  ///< how many numbers are skipped; 0 where no step fits
};

/// The places where the names of a naturally sorted stack do not count on. One of their numbers has
/// to rise through the whole stack, by its smallest step; others may change beside it, as the time
/// does. Where none rises throughout, the places are those between names that differ in letters
/// (endings aside), in no number or in more than one.
std::vector<NumberGap> number_gaps(const std::vector<std::string>& sorted_names);

/// How often each of two numbers is counted.
struct NumberGrid {
  std::size_t outer = 0;  ///< values of the number that stands first in the names
  std::size_t inner = 0;
};

/// The two numbers of names that hold every pair of them, as several channels of a stack do;
/// nothing for other names.
std::optional<NumberGrid> number_grid(const std::vector<std::string>& names);

}  // namespace octavo
