#include "text/made_by_words.h"

#include <fmt/format.h>

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/core/json_reader.h"
#include "octavo/core/text.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo::cli {

namespace {

std::string list_words(JsonReader& in);

/// The value that `in` stands at, in words; "" for what is no number, text, or list of such. Moves
/// to its last token.
std::string value_words(JsonReader& in) {
  if (in.token() == JsonToken::string) return in.string();
  if (in.token() == JsonToken::begin_list) return list_words(in);
  const std::optional<double> number = in.number();
  in.skip_value();
  return number ? number_text(*number) : "";
}

std::string list_words(JsonReader& in) {
  std::string text;
  bool is_plain = true;
  while (in.next() != JsonToken::end_list) {
    const bool is_list = in.token() == JsonToken::begin_list;
    const std::string words = value_words(in);
    is_plain = is_plain && !is_list && !words.empty();
    text += (text.empty() ? "" : ",") + words;
  }
  return is_plain ? text : "";
}

/// "2 = -30:225": the label where it is not 1.
std::string range_words(JsonReader& in) {
  std::string label;
  std::string low;
  std::string high;
  while (in.next() != JsonToken::end_object) {
    const std::string name = in.string();
    in.next();
    const std::optional<double> number = in.number();
    in.skip_value();
    const std::string words = number ? number_text(*number) : "";
    if (name == "label" && number != 1) label = words;
    if (name == "low") low = words;
    if (name == "high") high = words;
  }
  return (label.empty() ? "" : label + " = ") + low + ":" + high;
}

/// "226:, 2 = -30:225".
std::string ranges_words(JsonReader& in) {
  std::string text;
  while (in.next() != JsonToken::end_list) {
    if (in.token() != JsonToken::begin_object) {
      in.skip_value();
      continue;
    }
    text += (text.empty() ? "" : ", ") + range_words(in);
  }
  return text;
}

/// One setting; "" for what has no words. The step of an operation that has a setting of its name
/// is that setting.
std::string setting_words(const JsonMember& setting, const JsonObject& settings) {
  std::string name = setting.name;
  std::replace(name.begin(), name.end(), '_', ' ');
  JsonReader in(setting.json);
  in.next();
  if (name == "step" && in.token() == JsonToken::string) {
    return settings.json_of(in.string()).empty() ? in.string() : "";
  }
  if (name == "ranges" && in.token() == JsonToken::begin_list) return name + " " + ranges_words(in);
  if (in.token() == JsonToken::boolean) return in.boolean() ? name : "";
  const std::string words = value_words(in);
  return words.empty() ? "" : name + " " + words;
}

}  // namespace

bool is_condensed(const Metadata& metadata) {
  const auto& made_by = metadata.facts().made_by;
  return made_by && made_by->operation() == "condense";
}

std::string made_by_words(const Metadata& metadata) {
  const auto& made_by = metadata.facts().made_by;
  if (!made_by) return "";
  if (const auto flat = made_by->number("flat"); flat && is_condensed(metadata)) {
    const std::string unit = unit_of(metadata);
    return fmt::format("condensed with tolerance {}{}: cubes that vary no more hold their mean",
                       number_text(*flat), unit.empty() ? "" : " " + unit);
  }
  std::string text;
  for (const JsonMember& setting : made_by->settings().members()) {
    const std::string words = setting_words(setting, made_by->settings());
    if (!words.empty()) text += (text.empty() ? ": " : ", ") + words;
  }
  return escaped(made_by->operation() + text);
}

}  // namespace octavo::cli
