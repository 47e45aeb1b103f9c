// Names of labels in tables, in CSV and in JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"

namespace octavo::cli {

/// A column of a table: a name in each row, escaped. It takes no place where all names are empty.
class NameColumn {
 public:
  explicit NameColumn(const std::vector<std::string>& names);

  bool is_empty() const { return width_ == 0; }
  /// Two blanks and "name", as wide as the column.
  std::string head() const;
  std::string cell(std::size_t row) const;

 private:
  std::string padded(const std::string& text) const;

  std::vector<std::string> cells_;
  std::size_t width_ = 0;
};

/// The name of a label, or null.
nlohmann::ordered_json name_json(const LabelNames& names, std::int64_t label);

/// " Precentral_L", or "" for a label without a name.
std::string name_suffix(const LabelNames& names, std::int64_t label);

/// A text as a cell of CSV (RFC 4180); escaped where it holds control characters.
std::string csv_cell(const std::string& text);

/// "116 named: 1 Precentral_L, 2 Precentral_R, 3 Frontal_Sup_L, ..."; "" where none is.
std::string named_labels_text(const LabelNames& names);

}  // namespace octavo::cli
