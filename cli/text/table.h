// Rows of a result as a table for people.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace octavo::cli {

enum class Align { right, left };

struct TextColumn {
  std::string head;
  std::size_t width = 0;  ///< longer cells push what follows
  Align align = Align::right;
};

/// The column of names, as wide as they are; it is left out where all of them are empty.
TextColumn name_column();

/// Columns with a blank in between, two before one that is aligned to the left behind one that is
/// not. Lines end without blanks.
class TextTable {
 public:
  explicit TextTable(std::vector<TextColumn> columns) : columns_(std::move(columns)) {}

  /// cells  one of each column; those of name_column() as they are, here they are escaped
  void add(std::vector<std::string> cells);

  /// The heads and all rows, a line each.
  std::string text() const;

 private:
  std::vector<TextColumn> columns_;
  std::vector<std::vector<std::string>> rows_;
};

}  // namespace octavo::cli
