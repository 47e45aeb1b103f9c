#include "octavo/io/source/data_files.h"

#include <algorithm>
#include <charconv>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/io/source/header_text.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

/// "%03d" in a name.
struct NumberPlace {
  std::size_t begin = 0;
  std::size_t end = 0;
  std::size_t width = 0;
  bool is_padded = false;  ///< with zeros, else with blanks
};

std::optional<NumberPlace> find_number(std::string_view name) {
  constexpr std::size_t kMaxWidth = 99;
  NumberPlace place;
  place.begin = name.find('%');
  if (place.begin == std::string_view::npos) return std::nullopt;
  std::size_t at = place.begin + 1;
  place.is_padded = at < name.size() && name[at] == '0';
  for (; at < name.size() && name[at] >= '0' && name[at] <= '9'; ++at) {
    place.width = place.width * 10 + static_cast<std::size_t>(name[at] - '0');
    if (place.width > kMaxWidth) return std::nullopt;
  }
  if (at == name.size() || std::string_view("diu").find(name[at]) == std::string_view::npos) {
    return std::nullopt;
  }
  place.end = at + 1;
  if (name.find('%', place.end) != std::string_view::npos) return std::nullopt;
  return place;
}

std::string numbered_name(std::string_view pattern, const NumberPlace& place,
                          std::int64_t number) {
  const std::string sign = number < 0 ? "-" : "";
  const std::string digits = std::to_string(number).substr(sign.size());
  const std::size_t taken = sign.size() + digits.size();
  const std::size_t padding = place.width > taken ? place.width - taken : 0;
  const std::string text = place.is_padded ? sign + std::string(padding, '0') + digits
                                           : std::string(padding, ' ') + sign + digits;
  return std::string(pattern.substr(0, place.begin)) + text +
         std::string(pattern.substr(place.end));
}

/// Numbers from first to last, whose difference may be larger than what int64 holds; none of a step
/// of 0.
std::uint64_t count_of(const NumberedNames& names) {
  const bool rises = names.step > 0;
  if (names.step == 0 || (rises ? names.first > names.last : names.first < names.last)) return 0;
  const auto first = static_cast<std::uint64_t>(names.first);
  const auto last = static_cast<std::uint64_t>(names.last);
  const auto step = static_cast<std::uint64_t>(names.step);
  const std::uint64_t steps = (rises ? last - first : first - last) / (rises ? step : 0 - step);
  // One more than the largest count is none that a volume has.
  return std::max(steps, steps + 1);
}

/// How many files an array stands in, of which `named` are named.
std::uint64_t expected_count(const std::string& header, std::span<const std::int64_t> sizes,
                             std::int64_t dimension, std::uint64_t named) {
  const auto all = static_cast<std::int64_t>(sizes.size());
  if (dimension < 1 || dimension > all) {
    reject(header, "data files of " + std::to_string(dimension) + " dimensions, 1 to " +
                       std::to_string(all) + " expected");
  }
  if (dimension == all) {
    const auto size = static_cast<std::uint64_t>(sizes.back());
    if (named > 0 && size % named == 0) return named;
    reject(header, "the last of its axes, of " + std::to_string(size) +
                       ", does not divide into " + std::to_string(named) +
                       " data files; repair the header");
  }
  std::int64_t count = 1;
  for (const std::int64_t size : sizes.subspan(static_cast<std::size_t>(dimension))) {
    count = checked_count(count, size, "data files");
  }
  return static_cast<std::uint64_t>(count);
}

}  // namespace

bool has_number_pattern(std::string_view name) { return find_number(name).has_value(); }

std::optional<PatternLine> pattern_line(std::string_view line, std::size_t most) {
  PatternLine result;
  line = trimmed(line);
  while (result.numbers.size() < most) {
    const std::size_t blank = line.find_last_of(" \t");
    if (blank == std::string_view::npos) break;
    const std::string_view word = line.substr(blank + 1);
    std::int64_t number = 0;
    const auto [end, failure] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (failure != std::errc() || end != word.data() + word.size()) break;
    result.numbers.insert(result.numbers.begin(), number);
    line = trimmed(line.substr(0, blank));
  }
  if (!has_number_pattern(line)) return std::nullopt;
  result.pattern = line;
  return result;
}

std::string_view dimension_digits(std::string_view word) {
  const bool has_mark = word.size() > 1 && (word.back() == 'D' || word.back() == 'd');
  return word.substr(0, word.size() - (has_mark ? 1 : 0));
}

DataFileNames DataFileNames::of_list(std::string_view lines) {
  DataFileNames names;
  while (!lines.empty()) {
    const std::size_t end = std::min(lines.find('\n'), lines.size());
    const std::string_view name = trimmed(lines.substr(0, end));
    lines.remove_prefix(std::min(end + 1, lines.size()));
    if (!name.empty()) names.listed_.emplace_back(name);
  }
  return names;
}

DataFileNames DataFileNames::of_pattern(NumberedNames numbered) {
  DataFileNames names;
  names.numbered_ = std::move(numbered);
  return names;
}

std::uint64_t DataFileNames::count() const {
  return numbered_ ? count_of(*numbered_) : listed_.size();
}

std::string DataFileNames::name(std::uint64_t number) const {
  if (!numbered_) return listed_[static_cast<std::size_t>(number)];
  // It lies between the first and the last one; the steps to it may be more than int64 holds.
  const std::uint64_t value = static_cast<std::uint64_t>(numbered_->first) +
                              static_cast<std::uint64_t>(numbered_->step) * number;
  return numbered_name(numbered_->pattern, *find_number(numbered_->pattern),
                       static_cast<std::int64_t>(value));
}

std::vector<std::string> find_data_files(const std::string& header, const DataFileNames& names,
                                         std::span<const std::int64_t> sizes,
                                         std::int64_t dimension) {
  const std::uint64_t count = expected_count(header, sizes, dimension, names.count());
  if (names.count() != count) {
    reject(header, "the header names " + std::to_string(names.count()) +
                       (names.count() == 1 ? " data file, " : " data files, ") +
                       std::to_string(count) + " expected by its sizes; repair the header");
  }
  std::vector<std::string> files;
  for (std::uint64_t i = 0; i < count; ++i) files.push_back(sibling_path(header, names.name(i)));
  return files;
}

std::uint64_t start_of_last(const std::string& path, std::uint64_t bytes) {
  const std::uint64_t length = SourceFile(path).size();
  if (length >= bytes) return length - bytes;
  reject(path, "the file is too short: " + std::to_string(bytes) +
                   " bytes of voxels expected at its end, " + std::to_string(length) +
                   " found; it is cut or its header is wrong");
}

void take_files(const std::string& header, const std::vector<std::string>& files,
                std::uint64_t total_bytes, const std::optional<PieceStart>& start,
                VoxelRun& run) {
  if (files.empty() || total_bytes % files.size() != 0) {
    reject(header, std::to_string(total_bytes) + " bytes of voxels do not divide into " +
                       std::to_string(files.size()) + " data files; repair the header");
  }
  run.piece_bytes = total_bytes / files.size();
  run.path = files.front();
  for (const std::string& path : files) {
    StreamPiece piece{path, start.value_or(PieceStart{})};
    if (!start) piece.start.offset = start_of_last(path, run.piece_bytes);
    run.pieces.push_back(std::move(piece));
  }
}

}  // namespace octavo
