#include "text/preparation_words.h"

#include <fmt/format.h>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

void add(std::string& text, const std::string& words) {
  text += (text.empty() ? "" : "; ") + words;
}

/// "channel red of 4".
std::string component_words(const char* what, const std::optional<ComponentNote>& component) {
  if (!component || !component->index) return "";
  return std::string(what) + " " +
         (component->name ? escaped(*component->name) : std::to_string(*component->index)) +
         " of " + count_text(component->count.value_or(0));
}

}  // namespace

std::string choice_words(const Metadata& metadata) {
  const MetadataFacts& facts = metadata.facts();
  std::string text;
  const auto add_choice = [&](const std::string& words) {
    if (!words.empty()) text += (text.empty() ? "" : ", ") + words;
  };
  if (facts.chosen) {
    add_choice(component_words("channel", facts.chosen->channel));
    add_choice(component_words("time", facts.chosen->time));
  }
  if (facts.segment) add_choice("segment " + std::to_string(facts.segment->number.value_or(0)));
  return text;
}

std::string preparation_words(const Metadata& metadata) {
  const PreparedNote prepared = metadata.facts().prepared.value_or(PreparedNote{});
  std::string text;
  if (const std::int64_t count = prepared.dropped_duplicates.value_or(0); count > 0) {
    add(text, counted_text(count, "copy of a slice", "copies of slices") + " left out");
  }
  if (const std::int64_t count = prepared.ignored_number_gaps.value_or(0); count > 0) {
    add(text, counted_text(count, "gap") + " in the numbers of its files passed over");
  }
  const GapsNote gaps = prepared.gaps.value_or(GapsNote{});
  if (const std::int64_t count = gaps.made_plane_count.value_or(0); count > 0) {
    add(text, counted_text(count, "plane") + (gaps.method == "background"
                                                  ? " without a slice left empty"
                                                  : " interpolated between slices"));
  }
  if (prepared.tilt && prepared.tilt->angle_degrees) {
    add(text, fmt::format("gantry tilt of {:.4g} degrees removed", *prepared.tilt->angle_degrees));
  }
  const IsotropicNote isotropic = prepared.isotropic.value_or(IsotropicNote{});
  if (const std::int64_t count = isotropic.made_plane_count.value_or(0); count > 0) {
    add(text, fmt::format("{} made between thick slices ({})", counted_text(count, "plane"),
                          escaped(isotropic.method.value_or("unknown way"))));
  }
  return text;
}

std::string missing_words(const Metadata& metadata) {
  const auto& repaired = metadata.facts().repaired;
  if (!repaired || !repaired->missing_planes) return "";
  const auto& [first, last] = *repaired->missing_planes;
  return fmt::format("planes {} to {} are missing: their build was interrupted", first, last);
}

bool was_resampled(const Metadata& metadata) {
  const auto& prepared = metadata.facts().prepared;
  return prepared && (prepared->gaps || prepared->tilt || prepared->isotropic);
}

}  // namespace octavo::cli
