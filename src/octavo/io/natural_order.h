// The order people expect of numbered file names: slice2 before slice10.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// True when `a` comes before `b`: runs of digits compare as numbers of any length, the rest byte
/// by byte. A strict total order: names with equal numbers ("01", "1") are ordered by their bytes.
bool natural_less(std::string_view a, std::string_view b) noexcept;

/// One sentence for each place where the numbers of a naturally sorted stack skip, none for an even
/// stack.
/// Names that differ in more than one number, or in letters, say nothing about gaps.
std::vector<std::string> number_gaps(const std::vector<std::string>& sorted_names);

}  // namespace octavo
