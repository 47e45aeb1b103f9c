#include "octavo/io/natural_order.h"

#include <algorithm>
#include <cstdint>
#include <optional>

namespace octavo {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The run of digits at `at`, without leading zeros; `at` moves behind it.
std::string_view take_number(std::string_view text, std::size_t& at) {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t start = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(start, at - start);
}

/// Less than, equal to or greater than 0, as the names compare with equal numbers held equal.
int compare_natural(std::string_view a, std::string_view b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view x = take_number(a, i);
      const std::string_view y = take_number(b, j);
      if (x.size() != y.size()) return x.size() < y.size() ? -1 : 1;
      if (const int order = x.compare(y); order != 0) return order;
    } else {
      if (a[i] != b[j]) {
        return static_cast<unsigned char>(a[i]) < static_cast<unsigned char>(b[j]) ? -1 : 1;
      }
      ++i;
      ++j;
    }
  }
  if (i < a.size()) return 1;
  return j < b.size() ? -1 : 0;
}

/// The numbers of a name and what stands between them.
struct NumberedName {
  std::string letters;
  std::vector<std::uint64_t> numbers;
};

std::optional<NumberedName> numbered(std::string_view name) {
  NumberedName result;
  for (std::size_t at = 0; at < name.size();) {
    if (!is_digit(name[at])) {
      result.letters += name[at++];
      continue;
    }
    const std::string_view digits = take_number(name, at);
    if (digits.size() > 18) return std::nullopt;
    std::uint64_t value = 0;
    for (const char c : digits) value = value * 10 + static_cast<std::uint64_t>(c - '0');
    result.letters += '#';
    result.numbers.push_back(value);
  }
  return result;
}

/// The difference of the one number in which two names differ.
std::optional<std::uint64_t> number_step(const std::string& before, const std::string& after) {
  const std::optional<NumberedName> a = numbered(before);
  const std::optional<NumberedName> b = numbered(after);
  if (!a || !b || a->letters != b->letters) return std::nullopt;
  std::optional<std::uint64_t> step;
  for (std::size_t i = 0; i < a->numbers.size(); ++i) {
    if (a->numbers[i] == b->numbers[i]) continue;
    if (step) return std::nullopt;
    step = b->numbers[i] - a->numbers[i];
  }
  return step;
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) noexcept {
  const int order = compare_natural(a, b);
  return order != 0 ? order < 0 : a < b;
}

std::vector<NumberGap> number_gaps(const std::vector<std::string>& sorted_names) {
  std::vector<std::uint64_t> steps;
  for (std::size_t i = 1; i < sorted_names.size(); ++i) {
    const std::optional<std::uint64_t> step = number_step(sorted_names[i - 1], sorted_names[i]);
    if (!step) return {};
    steps.push_back(*step);
  }
  if (steps.empty()) return {};
  const std::uint64_t usual = *std::min_element(steps.begin(), steps.end());
  std::vector<NumberGap> gaps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] == usual) continue;
    gaps.push_back({i, steps[i] % usual == 0 ? steps[i] / usual - 1 : 0});
  }
  return gaps;
}

}  // namespace octavo
