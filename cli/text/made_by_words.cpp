#include "text/made_by_words.h"

#include <fmt/format.h>

#include <algorithm>

#include "octavo/core/error.h"
#include "text/quantities.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

using Json = nlohmann::ordered_json;

std::string operation_of(const Json& metadata) {
  const auto made_by = metadata.find("made_by");
  if (made_by == metadata.end() || !made_by->is_object()) return "";
  const auto operation = made_by->find("operation");
  return operation != made_by->end() && operation->is_string() ? operation->get<std::string>() : "";
}

/// A value in words; "" for what is no number, text, or list of such.
std::string value_words(const Json& value) {
  if (value.is_number()) return number_text(value.get<double>());
  if (value.is_string()) return value.get<std::string>();
  std::string text;
  if (!value.is_array()) return text;
  for (const Json& one : value) {
    const std::string words = one.is_array() ? "" : value_words(one);
    if (words.empty()) return "";
    text += (text.empty() ? "" : ",") + words;
  }
  return text;
}

std::string end_words(const Json& range, const char* name) {
  const auto end = range.find(name);
  return end != range.end() && end->is_number() ? number_text(end->get<double>()) : "";
}

/// "226:, 2 = -30:225": each range behind its label, where that is not 1.
std::string ranges_words(const Json& ranges) {
  std::string text;
  for (const Json& range : ranges) {
    if (!range.is_object()) continue;
    const auto label = range.find("label");
    const bool is_named = label != range.end() && label->is_number() && *label != 1;
    text += (text.empty() ? "" : ", ") + (is_named ? value_words(*label) + " = " : "") +
            end_words(range, "low") + ":" + end_words(range, "high");
  }
  return text;
}

/// Everything that was noted of an operation, but its name.
std::string member_words(const Json& made_by) {
  std::string text;
  const auto add = [&](const std::string& words) { text += (text.empty() ? "" : ", ") + words; };
  for (const auto& [key, value] : made_by.items()) {
    std::string name = key;
    std::replace(name.begin(), name.end(), '_', ' ');
    const bool is_step = key == "step" && value.is_string();
    if (key == "operation" || (is_step && made_by.contains(value.get<std::string>()))) continue;
    if (key == "ranges" && value.is_array()) add(name + " " + ranges_words(value));
    else if (value == true) add(name);
    else if (is_step) add(value_words(value));
    else if (const std::string words = value_words(value); !words.empty()) add(name + " " + words);
  }
  return text;
}

}  // namespace

bool is_condensed(const Json& metadata) { return operation_of(metadata) == "condense"; }

std::string made_by_words(const Json& metadata) {
  const std::string operation = operation_of(metadata);
  if (operation.empty()) return "";
  const Json& made_by = metadata["made_by"];
  const std::string unit = unit_of(metadata);
  if (const auto flat = made_by.find("flat");
      is_condensed(metadata) && flat != made_by.end() && flat->is_number()) {
    return fmt::format("condensed with tolerance {}{}: cubes that vary no more hold their mean",
                       number_text(flat->get<double>()), unit.empty() ? "" : " " + unit);
  }
  const std::string members = member_words(made_by);
  return escaped(operation + (members.empty() ? "" : ": " + members));
}

}  // namespace octavo::cli
