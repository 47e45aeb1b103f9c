// Reading the text headers of MetaImage and NRRD: lines, words and numbers, nothing assumed.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace octavo {

/// Without blanks, tabs and line ends at both sides.
std::string_view trimmed(std::string_view text);

/// The words of a text, parted by blanks and tabs.
std::vector<std::string> words(std::string_view text);

/// A header field that must be numbers: knows its file and name for messages.
struct FieldText {
  const std::string& path;
  std::string_view name;
  std::string_view value;

  /// Whether another field has the same words; numbers count by their values.
  bool says_same(const FieldText& other) const;
  /// Every word as a number; "nan" is one. Throws Error{source_rejected} naming field and word.
  std::vector<double> numbers() const;
  /// Exactly `count` finite numbers. Throws Error{source_rejected} with both counts.
  std::vector<double> numbers(std::size_t count) const;
  /// One whole number. Throws Error{source_rejected}.
  std::int64_t integer() const;
  /// Every word as a whole number. Throws Error{source_rejected}.
  std::vector<std::int64_t> integers() const;
};

}  // namespace octavo
