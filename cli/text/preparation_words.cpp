#include "text/preparation_words.h"

#include <fmt/format.h>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

/// A member of an object, or null.
const nlohmann::ordered_json& member(const nlohmann::ordered_json& object, const char* name) {
  static const nlohmann::ordered_json kNull;
  if (!object.is_object()) return kNull;
  const auto found = object.find(name);
  return found == object.end() ? kNull : *found;
}

std::int64_t count_in(const nlohmann::ordered_json& object, const char* name) {
  const nlohmann::ordered_json& value = member(object, name);
  return value.is_number_integer() ? value.get<std::int64_t>() : 0;
}

void add(std::string& text, const std::string& words) {
  text += (text.empty() ? "" : "; ") + words;
}

}  // namespace

std::string choice_words(const nlohmann::ordered_json& metadata) {
  std::string text;
  for (const char* what : {"channel", "time"}) {
    const nlohmann::ordered_json& choice = member(member(metadata, "chosen"), what);
    if (!member(choice, "index").is_number_integer()) continue;
    const nlohmann::ordered_json& name = member(choice, "name");
    text += (text.empty() ? "" : ", ") + std::string(what) + " " +
            (name.is_string() ? escaped(name.get<std::string>())
                              : std::to_string(count_in(choice, "index"))) +
            " of " + count_text(count_in(choice, "count"));
  }
  if (const nlohmann::ordered_json& segment = member(metadata, "segment"); segment.is_object()) {
    text += (text.empty() ? "" : ", ") + std::string("segment ") +
            std::to_string(count_in(segment, "number"));
  }
  return text;
}

std::string preparation_words(const nlohmann::ordered_json& metadata) {
  const nlohmann::ordered_json& prepared = member(metadata, "prepared");
  std::string text;
  if (const std::int64_t count = count_in(prepared, "dropped_duplicates"); count > 0) {
    add(text, counted_text(count, "copy of a slice", "copies of slices") + " left out");
  }
  if (const std::int64_t count = count_in(prepared, "ignored_number_gaps"); count > 0) {
    add(text, counted_text(count, "gap") + " in the numbers of its files passed over");
  }
  const nlohmann::ordered_json& gaps = member(prepared, "gaps");
  if (const std::int64_t count = count_in(gaps, "made_plane_count"); count > 0) {
    const bool is_empty = member(gaps, "method") == "background";
    add(text, counted_text(count, "plane") + (is_empty ? " without a slice left empty"
                                                       : " interpolated between slices"));
  }
  if (const nlohmann::ordered_json& angle = member(member(prepared, "tilt"), "angle_degrees");
      angle.is_number()) {
    add(text, fmt::format("gantry tilt of {:.4g} degrees removed", angle.get<double>()));
  }
  const nlohmann::ordered_json& isotropic = member(prepared, "isotropic");
  if (const std::int64_t count = count_in(isotropic, "made_plane_count"); count > 0) {
    const nlohmann::ordered_json& method = member(isotropic, "method");
    add(text, fmt::format("{} made between thick slices ({})", counted_text(count, "plane"),
                          method.is_string() ? escaped(method.get<std::string>()) : "unknown way"));
  }
  return text;
}

std::string missing_words(const nlohmann::ordered_json& metadata) {
  const nlohmann::ordered_json& planes = member(member(metadata, "repaired"), "missing_planes");
  const bool is_pair = planes.is_array() && planes.size() == 2 && planes[0].is_number_integer() &&
                       planes[1].is_number_integer();
  if (!is_pair) return "";
  return fmt::format("planes {} to {} are missing: their build was interrupted",
                     planes[0].get<std::int64_t>(), planes[1].get<std::int64_t>());
}

bool was_resampled(const nlohmann::ordered_json& metadata) {
  const nlohmann::ordered_json& prepared = member(metadata, "prepared");
  return member(prepared, "gaps").is_object() || member(prepared, "tilt").is_object() ||
         member(prepared, "isotropic").is_object();
}

}  // namespace octavo::cli
