#include "octavo/io/source/header_text.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "octavo/core/error.h"

namespace octavo {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";

[[noreturn]] void reject(const FieldText& field, const std::string& why) {
  throw Error(ErrorKind::source_rejected,
              "header field \"" + escaped(field.name) + "\": " + why, field.path);
}

template <class T>
std::optional<T> number_in(std::string_view word) {
  T value{};
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (failure != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return value;
}

template <class T>
T parse_number(const FieldText& field, std::string_view word) {
  const std::optional<T> value = number_in<T>(word);
  if (!value) reject(field, escaped(word) + " is not a number it can hold");
  return *value;
}

bool is_same_word(std::string_view a, std::string_view b) {
  if (a == b) return true;
  const std::optional<double> in_a = number_in<double>(a);
  return in_a && in_a == number_in<double>(b);
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::vector<std::string> words(std::string_view text) {
  std::vector<std::string> result;
  for (text = trimmed(text); !text.empty(); text = trimmed(text)) {
    const std::size_t end = std::min(text.find_first_of(kBlanks), text.size());
    result.emplace_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return result;
}

bool FieldText::says_same(const FieldText& other) const {
  return std::ranges::equal(words(value), words(other.value), is_same_word);
}

std::vector<double> FieldText::numbers() const {
  std::vector<double> result;
  for (const std::string& word : words(value)) result.push_back(parse_number<double>(*this, word));
  return result;
}

std::vector<double> FieldText::numbers(std::size_t count) const {
  std::vector<double> result = numbers();
  if (result.size() != count) {
    reject(*this, std::to_string(count) + " numbers expected, " + std::to_string(result.size()) +
                      " found");
  }
  for (const double number : result) {
    if (!std::isfinite(number)) reject(*this, "a number is not finite");
  }
  return result;
}

std::int64_t FieldText::integer() const {
  const std::vector<std::int64_t> all = integers();
  if (all.size() != 1) reject(*this, "one whole number expected");
  return all.front();
}

std::vector<std::int64_t> FieldText::integers() const {
  std::vector<std::int64_t> result;
  for (const std::string& word : words(value)) {
    result.push_back(parse_number<std::int64_t>(*this, word));
  }
  return result;
}

}  // namespace octavo
