// The order people expect of numbered file names: slice2 before slice10.
#pragma once

#include <cstddef>
#include <string_view>

namespace octavo {

/// True when `a` comes before `b`: runs of digits compare as numbers of any length, the rest byte
/// by byte. A strict total order: names with equal numbers ("01", "1") are ordered by their bytes.
bool natural_less(std::string_view a, std::string_view b) noexcept;

bool is_digit(char c) noexcept;

/// The run of digits at `at`, without leading zeros; `at` moves behind it.
std::string_view take_digits(std::string_view text, std::size_t& at) noexcept;

}  // namespace octavo
