#include "octavo/io/source/label_names_file.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <deque>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string_view>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/given_label.h"
#include "octavo/core/utf8.h"
#include "octavo/io/source/label_table_xml.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMaxFileBytes = std::uint64_t{4} << 20;
constexpr std::size_t kMaxLineBytes = 4096;

struct Word {
  std::string_view text;
  bool is_quoted = false;
};

/// The words of a line that names a label.
struct Row {
  std::size_t line = 0;  // from 1
  std::vector<Word> words;
};

/// How the words of all rows are to be taken.
struct Layout {
  bool is_itk_snap = false;
  bool is_name_first = false;
  bool has_code = false;
  std::size_t color_words = 0;  // with an opacity 4
};

class LabelNamesFile {
 public:
  explicit LabelNamesFile(const std::string& path) : path_(path), text_(text_of_file()) {}

  LabelNames read() {
    if (is_xml()) take_xml();
    else take_rows();
    if (rows_.empty()) reject("names no label");
    if (are_pairs()) join_pairs();
    layout_ = find_layout();
    for (const Row& row : rows_) take_name(row);
    return std::move(names_);
  }

 private:
  [[noreturn]] void reject(const std::string& why) const {
    throw Error(ErrorKind::source_rejected, why, path_);
  }
  [[noreturn]] void reject_line(std::size_t line, const std::string& why) const {
    reject("line " + std::to_string(line) + ": " + why);
  }

  std::string text_of_file() const;
  bool is_xml() const;
  void take_xml();
  bool are_pairs() const;
  void join_pairs();
  void take_rows();
  void take_line(std::size_t number, std::string_view line);
  void require_text(std::size_t line, std::string_view text) const;
  void add_row(Row row);
  void require_name(const Row& row, std::size_t begin, std::size_t end) const;
  Layout find_layout() const;
  bool ends_in_codes() const;
  std::size_t numbers_at_end(const Row& row) const;
  void require_layout(const Row& row) const;
  void take_name(const Row& row);
  std::int64_t label(const Row& row, std::size_t at) const;
  LabelColor color(const Row& row, std::size_t at) const;

  const std::string& path_;
  std::string text_;
  std::deque<std::string> made_;  // lines and names that do not stand in the text so
  std::vector<Row> rows_;
  Layout layout_;
  std::map<std::int64_t, std::size_t> lines_;  // that named a label first
  LabelNames names_;
};

template <class T>
std::optional<T> number_in_word(const Word& word) {
  T value{};
  const char* end = word.text.data() + word.text.size();
  const auto [stop, failure] = std::from_chars(word.text.data(), end, value);
  const bool is_number = !word.is_quoted && failure == std::errc() && stop == end;
  return is_number ? std::optional(value) : std::nullopt;
}

bool is_finite_number(const Word& word) {
  return std::isfinite(number_in_word<double>(word).value_or(HUGE_VAL));
}

/// A number that a voxel can hold.
std::optional<std::int64_t> label_in_word(const Word& word) {
  const auto label = number_in_word<std::int64_t>(word);
  return label && is_label(*label) ? label : std::nullopt;
}

std::string joined(const Row& row, std::size_t begin, std::size_t end) {
  std::string text;
  for (std::size_t i = begin; i < end; ++i) {
    text.append(i == begin ? "" : " ").append(row.words[i].text);
  }
  return text;
}

/// INDEX R G B A VISIBLE MESH "NAME".
bool is_itk_snap(const Row& row) {
  constexpr std::size_t kName = 7;
  return row.words.size() > kName && label_in_word(row.words[0]) &&
         std::all_of(row.words.begin() + 1, row.words.begin() + kName, is_finite_number);
}

/// "#ff8000"
bool is_hex_color(std::string_view word) {
  return word.size() == 7 && word[0] == '#' &&
         word.find_first_not_of("0123456789abcdefABCDEF", 1) == std::string_view::npos;
}

/// In UTF-8, without a byte order mark.
std::string LabelNamesFile::text_of_file() const {
  const SourceFile file(path_);
  if (file.size() > kMaxFileBytes) reject("is longer than 4 MiB: no list of names");
  std::string text(static_cast<std::size_t>(file.size()), '\0');
  file.read_exactly(0, std::as_writable_bytes(std::span(text)));
  if (text.starts_with("\xff\xfe") || text.starts_with("\xfe\xff")) {
    reject("is text in UTF-16; save it as UTF-8");
  }
  if (text.starts_with("\xef\xbb\xbf")) text.erase(0, 3);
  return is_utf8(text) ? text : utf8_of_latin1(text);
}

bool LabelNamesFile::is_xml() const {
  const std::size_t first = text_.find_first_not_of(" \t\r\n");
  return first != std::string::npos && text_[first] == '<';
}

/// Labels of GIFTI as lines of ITK-SNAP.
void LabelNamesFile::take_xml() {
  const Word mark{"1", false};
  for (XmlLabel& label : labels_in_xml(text_)) {
    const auto kept = [&](std::string& text) {
      require_text(label.line, text);
      return std::string_view(made_.emplace_back(std::move(text)));
    };
    Row row{label.line, {{kept(label.key)}}};
    for (std::string& part : label.color) row.words.push_back({kept(part)});
    row.words.insert(row.words.end(), {mark, mark, mark, Word{kept(label.name), true}});
    add_row(std::move(row));
  }
}

/// Whether each second line is KEY R G B A, and the one before it a name.
bool LabelNamesFile::are_pairs() const {
  const auto is_key = [](const Row& row) {
    return row.words.size() == 5 && std::ranges::all_of(row.words, [](const Word& word) {
             return label_in_word(word).has_value();
           });
  };
  if (rows_.size() % 2 != 0 || is_key(rows_.front())) return false;
  for (std::size_t i = 1; i < rows_.size(); i += 2) {
    if (!is_key(rows_[i])) return false;
  }
  return true;
}

/// Pairs of lines as lines of ITK-SNAP.
void LabelNamesFile::join_pairs() {
  std::vector<Row> joined_rows;
  for (std::size_t i = 0; i < rows_.size(); i += 2) {
    made_.push_back(joined(rows_[i], 0, rows_[i].words.size()));
    Row& row = joined_rows.emplace_back(std::move(rows_[i + 1]));
    const Word mark{"1", false};
    row.words.insert(row.words.end(), {mark, mark, Word{made_.back(), true}});
  }
  rows_ = std::move(joined_rows);
}

void LabelNamesFile::take_rows() {
  std::size_t number = 0;
  for (std::size_t at = 0; at < text_.size();) {
    const std::size_t end = std::min(text_.find_first_of("\r\n", at), text_.size());
    take_line(++number, std::string_view(text_).substr(at, end - at));
    at = end + (std::string_view(text_).substr(end).starts_with("\r\n") ? 2 : 1);
  }
}

void LabelNamesFile::require_text(std::size_t line, std::string_view text) const {
  if (text.size() > kMaxLineBytes) reject_line(line, "is longer than 4096 bytes");
  if (has_control(text, "\t") || turns_text(text)) {
    reject_line(line, "holds a control character: no text");
  }
}

void LabelNamesFile::add_row(Row row) {
  if (rows_.size() == 2 * LabelNames::kMaxLabels) {
    throw Error(ErrorKind::limit_exceeded,
                "more lines than " + std::to_string(2 * LabelNames::kMaxLabels) + ", for the " +
                    std::to_string(LabelNames::kMaxLabels) + " labels that a file has names of",
                path_);
  }
  rows_.push_back(std::move(row));
}

void LabelNamesFile::take_line(std::size_t number, std::string_view line) {
  constexpr std::string_view kWordBlanks = " \t";
  require_text(number, line);
  Row row{number, {}};
  for (std::size_t at = line.find_first_not_of(kWordBlanks); at < line.size();
       at = line.find_first_not_of(kWordBlanks, at)) {
    if (row.words.empty() && line[at] == '#') return;
    const bool is_quoted = line[at] == '"';
    const std::size_t begin = at + (is_quoted ? 1 : 0);
    std::size_t end = is_quoted ? line.find('"', begin) : line.find_first_of(kWordBlanks, begin);
    if (is_quoted && end == std::string_view::npos) reject_line(number, "a quote is not closed");
    end = std::min(end, line.size());
    const std::size_t next = end + 1;
    if (is_quoted && next < line.size() && kWordBlanks.find(line[next]) == std::string_view::npos) {
      reject_line(number, "behind a closed quote stands no blank; names hold no quotes");
    }
    row.words.push_back({line.substr(begin, end - begin), is_quoted});
    if (!is_quoted && row.words.back().text.find('"') != std::string_view::npos) {
      reject_line(number, "a quote stands inside a word; names hold no quotes");
    }
    at = end + (is_quoted ? 1 : 0);
  }
  if (!row.words.empty()) add_row(std::move(row));
}

Layout LabelNamesFile::find_layout() const {
  Layout layout;
  layout.is_itk_snap = is_itk_snap(rows_.front());
  if (layout.is_itk_snap) return layout;
  layout.is_name_first = !label_in_word(rows_.front().words[0]);
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  for (const Row& row : rows_) fewest = std::min(fewest, numbers_at_end(row));
  if (layout.is_name_first) fewest -= std::min<std::size_t>(fewest, 1);
  layout.color_words = fewest >= 4 ? 4 : fewest == 3 ? 3 : 0;
  layout.has_code = !layout.is_name_first && ends_in_codes();
  return layout;
}

/// Whether every row is a number, a name and a number, and the names alone differ. Behind names of
/// several words small numbers are part of them.
bool LabelNamesFile::ends_in_codes() const {
  constexpr double kSmallestCode = 1000;
  std::set<std::string> names;
  return std::all_of(rows_.begin(), rows_.end(), [&](const Row& row) {
    const std::size_t last = row.words.size() - 1;
    return row.words.size() >= 3 && numbers_at_end(row) == 1 &&
           (last == 2 || number_in_word<double>(row.words[last]) >= kSmallestCode) &&
           names.insert(joined(row, 1, last)).second;
  });
}

/// The numbers at the end of a row behind its first two words.
std::size_t LabelNamesFile::numbers_at_end(const Row& row) const {
  const bool is_name_first = !label_in_word(rows_.front().words[0]);
  const std::size_t others = std::min<std::size_t>(row.words.size(), is_name_first ? 1 : 2);
  const auto end = row.words.rend() - static_cast<std::ptrdiff_t>(others);
  return static_cast<std::size_t>(
      std::find_if_not(row.words.rbegin(), end, is_finite_number) - row.words.rbegin());
}

void LabelNamesFile::require_layout(const Row& row) const {
  if (layout_.is_itk_snap) {
    if (is_itk_snap(row)) return;
    reject_line(row.line, "expected INDEX R G B A VIS MSH \"NAME\", as in the lines above");
  }
  const std::size_t labels = layout_.is_name_first ? 1 : 0;
  const std::size_t numbers = numbers_at_end(row);
  if (row.words.size() < 2 || numbers < labels) {
    reject_line(row.line, "'" + escaped(joined(row, 0, row.words.size())) +
                              "' is neither a number and a name nor a name and a number");
  }
  const std::size_t others = numbers - labels;
  if (layout_.color_words == 4 || others < 3 || others == layout_.color_words) return;
  reject_line(row.line, "ends in " + std::to_string(others) +
                            " numbers, other lines in fewer: give every label a color or none, "
                            "and put names that end in numbers in quotes");
}

std::int64_t LabelNamesFile::label(const Row& row, std::size_t at) const {
  const auto label = label_in_word(row.words[at]);
  if (label) return *label;
  reject_line(row.line, "'" + escaped(row.words[at].text) +
                            "' is no label: expected a whole number of at most 32 bits");
}

LabelColor LabelNamesFile::color(const Row& row, std::size_t at) const {
  LabelColor color{};
  for (std::size_t i = 0; i < color.size(); ++i) {
    const Word& word = row.words[at + i];
    const auto value = number_in_word<int>(word);
    if (!value || *value < 0 || *value > 255) {
      reject_line(row.line,
                  "'" + escaped(word.text) + "' is no part of a color: expected 0 to 255");
    }
    color[i] = static_cast<std::uint8_t>(*value);
  }
  return color;
}

/// Proves that the words of a name can be no other part of a line.
void LabelNamesFile::require_name(const Row& row, std::size_t begin, std::size_t end) const {
  constexpr std::size_t kColor = 3;
  const std::span<const Word> name = std::span(row.words).subspan(begin, end - begin);
  if (name.size() > 1 && std::ranges::any_of(name, &Word::is_quoted)) {
    reject_line(row.line, "a name in quotes stands beside other words");
  }
  if (name.size() > kColor && std::ranges::all_of(name.first(kColor), is_finite_number)) {
    reject_line(row.line, "the name begins with three numbers; put it in quotes, or give all of "
                          "INDEX R G B A VIS MSH \"NAME\"");
  }
}

void LabelNamesFile::take_name(const Row& row) {
  require_layout(row);

  // Where The Parts Stand
  const std::size_t end = row.words.size() - layout_.color_words - (layout_.has_code ? 1 : 0);
  std::size_t label_at = 0;
  std::size_t color_at = end;
  std::size_t name_begin = 1;
  std::size_t name_end = end;
  if (layout_.is_itk_snap) {
    color_at = 1;
    name_begin = 7;
  } else if (layout_.is_name_first) {
    label_at = name_end = end - 1;
    name_begin = 0;
  }

  require_name(row, name_begin, name_end);

  // What They Say
  const std::int64_t number = label(row, label_at);
  LabelName entry{joined(row, name_begin, name_end), {}};
  if (layout_.is_itk_snap || layout_.color_words > 0) entry.color = color(row, color_at);
  if (is_hex_color(row.words.back().text)) {
    reject_line(row.line, "ends in a color in hexadecimal; give its parts as three numbers, 0 to "
                          "255");
  }
  const bool is_color_alone = entry.name.empty() && entry.color;
  const std::string fault = is_color_alone ? "" : label_name_fault(entry.name);
  if (!fault.empty()) reject_line(row.line, "the name " + fault);

  const auto [first, is_new] = lines_.emplace(number, row.line);
  if (!is_new && names_.all().at(number) != entry) {
    reject_line(row.line, "label " + std::to_string(number) + " has another name in line " +
                              std::to_string(first->second));
  }
  names_.set(number, std::move(entry));
}

}  // namespace

LabelNames read_label_names(const std::string& path) {
  try {
    return LabelNamesFile(path).read();
  } catch (const Error& error) {
    throw error.with_path(path);
  }
}

}  // namespace octavo
