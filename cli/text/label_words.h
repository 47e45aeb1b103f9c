// Names of labels in tables, in CSV and in JSON.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"

namespace octavo::cli {

/// The name of a label, or null.
nlohmann::ordered_json name_json(const LabelNames& names, std::int64_t label);

/// " Precentral_L", or "" for a label without a name.
std::string name_suffix(const LabelNames& names, std::int64_t label);

/// A text as a cell of CSV (RFC 4180); escaped where it holds control characters.
std::string csv_cell(const std::string& text);

/// "116 named: 1 Precentral_L, 2 Precentral_R, 3 Frontal_Sup_L, ..."; "" where none is.
std::string named_labels_text(const LabelNames& names);

}  // namespace octavo::cli
