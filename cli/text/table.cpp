#include "text/table.h"

#include <fmt/format.h>

#include <algorithm>

#include "octavo/core/error.h"

namespace octavo::cli {

namespace {

// Longer names reach beyond their column.
constexpr std::size_t kMaxNameWidth = 40;

bool is_of_names(const TextColumn& column) { return column.width == 0 && column.head == "name"; }

std::string line_of(const std::vector<TextColumn>& columns, const std::vector<std::string>& cells) {
  std::string line;
  Align before = Align::left;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const auto& [head, width, align] = columns[i];
    if (is_of_names(columns[i])) continue;
    if (i > 0) line += align == Align::left && before == Align::right ? "  " : " ";
    line += align == Align::left ? fmt::format("{:<{}}", cells[i], width)
                                 : fmt::format("{:>{}}", cells[i], width);
    before = align;
  }
  return line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
}

}  // namespace

TextColumn name_column() { return {"name", 0, Align::left}; }

void TextTable::add(std::vector<std::string> cells) {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    if (is_of_names(columns_[i])) cells[i] = escaped(cells[i]);
  }
  rows_.push_back(std::move(cells));
}

std::string TextTable::text() const {
  std::vector<TextColumn> columns = columns_;
  std::vector<std::string> heads;
  for (std::size_t i = 0; i < columns.size(); ++i) {
    heads.push_back(columns[i].head);
    if (!is_of_names(columns[i])) continue;
    std::size_t longest = 0;
    for (const std::vector<std::string>& cells : rows_) {
      longest = std::max(longest, std::min(cells[i].size(), kMaxNameWidth));
    }
    if (longest > 0) columns[i].width = std::max(longest, columns[i].head.size());
  }
  std::string text = line_of(columns, heads);
  for (const std::vector<std::string>& cells : rows_) text += line_of(columns, cells);
  return text;
}

}  // namespace octavo::cli
