// What tasks found, as JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "octavo/core/json_text.h"
#include "octavo/tasks/result_facts.h"

namespace octavo::cli {

nlohmann::ordered_json json_of(const JsonObject& object);
/// Facts, and all that one can hold: of an optional the value, or null.
nlohmann::ordered_json json_of(const FactValue& value);

/// A text, or null where it is empty.
nlohmann::ordered_json text_json(const std::string& text);

/// A list of what `of` makes of each one of `all`.
template <class All, class Of>
nlohmann::ordered_json json_list(const All& all, Of of) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const auto& one : all) list.push_back(of(one));
  return list;
}

}  // namespace octavo::cli
