#include "text/identity_words.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/context.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

using nlohmann::ordered_json;

/// A member that is an object, or an empty one.
ordered_json object_in(const ordered_json& object, const char* name) {
  const auto found = object.find(name);
  return found != object.end() && found->is_object() ? *found : ordered_json::object();
}

ordered_json identity_of(const ordered_json& metadata) { return object_in(metadata, "identity"); }

ordered_json kept_in(const ordered_json& metadata) {
  return object_in(identity_of(metadata), "attributes");
}

ordered_json dropped_in(const ordered_json& metadata) {
  return object_in(identity_of(metadata), "dropped");
}

std::string counted(std::size_t count) {
  return counted_text(static_cast<std::int64_t>(count), "attribute");
}

}  // namespace

const char* identity_state(const ordered_json& metadata) {
  if (!kept_in(metadata).empty()) return "kept";
  return dropped_in(metadata).empty() ? "none" : "dropped";
}

std::string identity_words(const ordered_json& metadata) {
  const std::size_t kept = kept_in(metadata).size();
  const std::size_t dropped = dropped_in(metadata).size();
  if (kept > 0) {
    return fmt::format("kept: {} that may tell who or where {} in this file (--metadata)",
                       counted(kept), kept == 1 ? "is" : "are");
  }
  if (dropped == 0) return "";
  return fmt::format("dropped: {} of the source left out (--metadata)", counted(dropped));
}

std::string identity_lines(const ordered_json& metadata) {
  std::string text;
  const ordered_json kept = kept_in(metadata);
  if (!kept.empty()) text += "\n  kept of what may tell who or where:\n";
  for (const auto& [name, value] : kept.items()) {
    const std::string words = value.is_string() ? value.get<std::string>() : value.dump();
    text += fmt::format("    {:<36} {}\n", one_line(name), one_line(words));
  }
  const ordered_json dropped = dropped_in(metadata);
  if (!dropped.empty()) text += "\n  dropped, and how often it was there:\n";
  for (const auto& [name, count] : dropped.items()) {
    text += fmt::format("    {:<36} {}\n", one_line(name),
                        count.is_number_integer() ? count_text(count.get<std::int64_t>()) : "");
  }
  return text;
}

}  // namespace octavo::cli
