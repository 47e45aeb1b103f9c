// The order people expect of numbered file names: slice2 before slice10.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// True when `a` comes before `b`: runs of digits compare as numbers of any length, the rest byte
/// by byte. A strict total order: names with equal numbers ("01", "1") are ordered by their bytes.
bool natural_less(std::string_view a, std::string_view b) noexcept;

/// Two names of a stack between whose numbers others are missing.
struct NumberGap {
  std::size_t before = 0;     ///< index of the first of the two; the other follows it
  std::uint64_t missing = 0;  ///< how many numbers are skipped; 0 where no step fits
};

/// The places where the numbers of a naturally sorted stack skip, against the smallest step in it.
/// None for names that differ in more than one number, or in letters: they say nothing about gaps.
std::vector<NumberGap> number_gaps(const std::vector<std::string>& sorted_names);

}  // namespace octavo
