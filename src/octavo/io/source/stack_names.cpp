#include "octavo/io/source/stack_names.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <utility>

#include "octavo/io/source/natural_order.h"

namespace octavo {

namespace {

/// The numbers of a name and what stands between them, without its ending.
struct NumberedName {
  std::string letters;
  std::vector<std::int64_t> numbers;
};

/// `name` without what follows its last point, where that holds no digit.
std::string_view without_ending(std::string_view name) {
  const std::size_t point = name.rfind('.');
  if (point == std::string_view::npos) return name;
  const std::string_view ending = name.substr(point);
  return std::any_of(ending.begin(), ending.end(), is_digit) ? name : name.substr(0, point);
}

/// Numbers too long to count with are taken for letters.
NumberedName numbered(std::string_view name) {
  constexpr std::size_t kMostDigits = 18;  // of an int64, whatever they are
  NumberedName result;
  for (std::size_t at = 0; at < name.size();) {
    if (!is_digit(name[at])) {
      result.letters += name[at++];
      continue;
    }
    const std::string_view digits = take_digits(name, at);
    if (digits.size() > kMostDigits) {
      result.letters += digits;
      continue;
    }
    std::int64_t value = 0;
    for (const char c : digits) value = value * 10 + (c - '0');
    result.letters += '#';
    result.numbers.push_back(value);
  }
  return result;
}

/// All names, where they have the same letters; otherwise nothing.
std::vector<NumberedName> alike(const std::vector<std::string>& names) {
  std::vector<NumberedName> all;
  for (const std::string& name : names) {
    NumberedName parsed = numbered(without_ending(name));
    if (!all.empty() && parsed.letters != all.front().letters) return {};
    all.push_back(std::move(parsed));
  }
  return all;
}

/// The gaps of number `field`, which rises through the whole stack; nothing where it does not.
std::optional<std::vector<NumberGap>> gaps_of(const std::vector<NumberedName>& names,
                                              std::size_t field) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < names.size(); ++i) {
    steps.push_back(names[i].numbers[field] - names[i - 1].numbers[field]);
    if (steps.back() <= 0) return std::nullopt;
  }
  const std::int64_t usual = *std::min_element(steps.begin(), steps.end());
  std::vector<NumberGap> gaps;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    if (steps[i] == usual) continue;
    const std::int64_t missing = steps[i] % usual == 0 ? steps[i] / usual - 1 : 0;
    gaps.push_back({i, true, static_cast<std::uint64_t>(missing)});
  }
  return gaps;
}

/// The number in which alone two names differ.
std::optional<std::size_t> changed_field(const std::string& before, const std::string& after) {
  const std::vector<NumberedName> both = alike({before, after});
  if (both.empty()) return std::nullopt;
  std::optional<std::size_t> changed;
  for (std::size_t field = 0; field < both[0].numbers.size(); ++field) {
    if (both[0].numbers[field] == both[1].numbers[field]) continue;
    if (changed) return std::nullopt;
    changed = field;
  }
  return changed;
}

/// The places where names that no number counts through break off.
std::vector<NumberGap> breaks_of(const std::vector<std::string>& names) {
  std::vector<NumberGap> breaks;
  std::optional<std::size_t> counted;
  for (std::size_t i = 1; i < names.size(); ++i) {
    const std::optional<std::size_t> changed = changed_field(names[i - 1], names[i]);
    if (!counted) counted = changed;
    if (!changed || changed != counted) breaks.push_back({i - 1, false, 0});
  }
  return breaks;
}

}  // namespace

std::vector<NumberGap> number_gaps(const std::vector<std::string>& sorted_names) {
  if (sorted_names.size() < 2) return {};
  const std::vector<NumberedName> names = alike(sorted_names);
  std::optional<std::vector<NumberGap>> fewest;
  const std::size_t fields = names.empty() ? 0 : names.front().numbers.size();
  for (std::size_t field = 0; field < fields; ++field) {
    auto gaps = gaps_of(names, field);
    if (gaps && (!fewest || gaps->size() < fewest->size())) fewest = std::move(gaps);
  }
  return fewest ? *fewest : breaks_of(sorted_names);
}

std::optional<NumberGrid> number_grid(const std::vector<std::string>& names) {
  const std::vector<NumberedName> all = alike(names);
  if (all.empty()) return std::nullopt;
  std::vector<std::size_t> counts;
  for (std::size_t field = 0; field < all.front().numbers.size(); ++field) {
    std::set<std::int64_t> values;
    for (const NumberedName& name : all) values.insert(name.numbers[field]);
    if (values.size() > 1) counts.push_back(values.size());
  }
  std::set<std::vector<std::int64_t>> pairs;
  for (const NumberedName& name : all) pairs.insert(name.numbers);
  const bool is_grid = counts.size() == 2 && pairs.size() == all.size() &&
                       counts[0] * counts[1] == all.size();
  if (!is_grid) return std::nullopt;
  return NumberGrid{counts[0], counts[1]};
}

}  // namespace octavo
