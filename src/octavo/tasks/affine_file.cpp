#include "octavo/tasks/affine_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

// Longer files are no matrices.
constexpr std::size_t kMostBytes = 64 << 10;

std::string text_of(const std::string& path) {
  const std::vector<std::byte> head = file_head(path, kMostBytes + 1);
  if (head.size() > kMostBytes) {
    reject(path, "is longer than 64 KiB: no matrix of 12 or 16 numbers");
  }
  return {reinterpret_cast<const char*>(head.data()), head.size()};
}

/// A finite number that fills the word.
std::optional<double> number_in(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [stop, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_whole = failure == std::errc() && stop == word.data() + word.size();
  return is_whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::vector<double> numbers_of(const std::string& path) {
  constexpr std::string_view kBetween = " \t\r,;[]()";
  std::vector<double> numbers;
  int line_number = 0;
  std::istringstream lines(text_of(path));
  for (std::string line; std::getline(lines, line);) {
    ++line_number;
    line.resize(std::min(line.size(), line.find('#')));
    for (std::size_t at = line.find_first_not_of(kBetween); at != std::string::npos;) {
      const std::size_t end = line.find_first_of(kBetween, at);
      const std::string word = line.substr(at, end - at);
      const std::optional<double> number = number_in(word);
      if (!number) {
        reject(path, fmt::format("'{}' in line {} is no number", escaped(word), line_number));
      }
      numbers.push_back(*number);
      at = line.find_first_not_of(kBetween, end);
    }
  }
  return numbers;
}

}  // namespace

Affine read_affine(const std::string& path) {
  const std::vector<double> m = numbers_of(path);
  if (m.size() != 12 && m.size() != 16) {
    reject(path, fmt::format("holds {} numbers; expected 12 or 16, the rows of a 4 x 4 matrix",
                             m.size()));
  }
  if (m.size() == 16 && (m[12] != 0 || m[13] != 0 || m[14] != 0 || m[15] != 1)) {
    reject(path, fmt::format("the last row is {} {} {} {}; expected 0 0 0 1", m[12], m[13], m[14],
                             m[15]));
  }
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t i = 0; i < 3; ++i) map.linear[3 * row + i] = m[4 * row + i];
    map.offset[row] = m[4 * row + 3];
  }
  if (!inverse(map)) reject(path, "the matrix has no inverse: it makes space flat");
  return map;
}

}  // namespace octavo
