#include "text/comparison_words.h"

#include <fmt/format.h>

#include <optional>

#include "octavo/core/text.h"
#include "text/fact_json.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/table.h"

namespace octavo::cli {

namespace {

/// What A calls a label, and what B does where that is something else.
std::string name_in_both(const CompareLabelsResult& result, std::int64_t label) {
  const std::string& in_a = result.names_a.name_of(label);
  const std::string& in_b = result.names_b.name_of(label);
  if (in_a.empty() || in_b.empty() || in_a == in_b) return in_a.empty() ? in_b : in_a;
  return in_a + " (B: " + in_b + ")";
}

std::string other_bits_text(const Comparison& c) {
  return fmt::format("{} of equal value {} other bits: -0 or another NaN",
                     counted_text(c.other_bits, "voxel"), c.other_bits == 1 ? "has" : "have");
}

/// Stored values were compared, and a slope makes others of their differences.
bool has_other_real_values(const Comparison& c) {
  return !c.is_real_units && c.max_real_difference != c.max_difference;
}

std::string largest_difference_text(const Comparison& c) {
  const std::string real = number_text(c.max_real_difference);
  if (!has_other_real_values(c)) return real;
  return fmt::format("{} in real units ({} as stored)", real, number_text(c.max_difference));
}

/// How far those voxels are apart that differ.
std::string difference_words(const Comparison& c) {
  const std::string by_at_most = "by at most " + largest_difference_text(c);
  if (c.nan_in_one == 0) return by_at_most;
  if (c.nan_in_one == c.different) return "all of them NaN in one alone";
  return fmt::format("{} of them NaN in one alone, others {}", count_text(c.nan_in_one),
                     by_at_most);
}

}  // namespace

std::vector<std::string> comparison_lines(const Comparison& c, const VolumeDescription& a,
                                          const VolumeDescription& b) {
  if (!c.is_same_size) {
    return {fmt::format("size: {} against {} voxels", size_text(a.size), size_text(b.size))};
  }
  std::vector<std::string> lines;
  if (!c.is_same_place) {
    lines.push_back(fmt::format(
        "geometry: up to {} mm apart; origin {} against {} mm, spacing {} against {} mm",
        number_text(c.shift_mm), point_text(a.geometry.origin_mm, ", "),
        point_text(b.geometry.origin_mm, ", "), point_text(a.geometry.spacing_mm),
        point_text(b.geometry.spacing_mm)));
  }
  if (!c.is_same_rescale && c.different > 0) {
    lines.push_back(fmt::format("rescale: slope {}, intercept {} against slope {}, intercept {}",
                                number_text(a.rescale.slope), number_text(a.rescale.intercept),
                                number_text(b.rescale.slope), number_text(b.rescale.intercept)));
  }
  if (c.different > 0) {
    const auto [first_a, first_b] = unlike_texts(c.first_values[0], c.first_values[1]);
    lines.push_back(fmt::format(
        "voxels: {} of {} differ, {}; first at x,y,z = {},{},{}: {} against {}{}",
        count_text(c.different), count_text(c.voxels), difference_words(c), c.first.x,
        c.first.y, c.first.z, first_a, first_b, has_other_real_values(c) ? " as stored" : ""));
  }
  if (c.other_bits > 0) lines.push_back("bits: " + other_bits_text(c));
  return lines;
}

nlohmann::ordered_json comparison_json(const Comparison& c) {
  nlohmann::ordered_json first = nullptr;
  if (c.different > 0) {
    first = {{"index", {c.first.x, c.first.y, c.first.z}}, {"values", c.first_values}};
  }
  return {{"equal", c.is_equal()},
          {"same_size", c.is_same_size},
          {"same_type", c.is_same_type},
          {"same_rescale", c.is_same_rescale},
          {"same_geometry", c.is_same_size && c.is_same_place},
          {"geometry_known", c.is_place_known},
          {"shift_mm", json_of(c.is_place_known ? std::optional(c.shift_mm) : std::nullopt)},
          {"compared_as", c.is_by_digest    ? "digest"
                          : c.is_real_units ? "real"
                                            : "stored"},
          {"voxels", c.voxels},
          {"different", c.different},
          {"nan_in_one", c.nan_in_one},
          {"other_bits", c.other_bits},
          {"max_difference", c.max_difference},
          {"max_real_difference", c.max_real_difference},
          {"first", first}};
}

std::string equal_text(const CompareResult& result) {
  const Comparison& c = result.comparison;
  std::string text =
      fmt::format("the same: {}, {}", counted_text(c.voxels, "voxel"),
                  c.is_by_digest    ? "by the digests that both files state"
                  : c.is_real_units ? "real values compared"
                                    : "stored values compared");
  if (c.max_difference > 0) {
    text += ", largest difference " + largest_difference_text(c);
  }
  if (c.other_bits > 0) text += ", but " + other_bits_text(c);
  if (!c.is_same_type) {
    text += fmt::format(", {} against {}", voxel_type_name(result.a.type),
                        voxel_type_name(result.b.type));
  }
  if (!c.is_place_known) text += ", places not compared: a spacing is not known";
  else if (c.shift_mm > 0) text += fmt::format(", places within {} mm", number_text(c.shift_mm));
  return text;
}

std::string agreement_table(const CompareLabelsResult& result) {
  TextTable table({{"label", 10},
                   name_column(),
                   {"voxels in A", 16},
                   {"voxels in B", 16},
                   {"in both", 16},
                   {"Dice", 8}});
  for (const LabelAgreement& one : result.agreements) {
    table.add({std::to_string(one.label), name_in_both(result, one.label),
               count_of(one.first_voxels), count_of(one.second_voxels), count_of(one.both_voxels),
               fmt::format("{:.4f}", one.dice())});
  }
  return table.text();
}

nlohmann::ordered_json agreements_json(const CompareLabelsResult& result) {
  return json_list(result.agreements, [&](const LabelAgreement& one) -> nlohmann::ordered_json {
    return {{"label", one.label},
            {"a_name", name_json(result.names_a, one.label)},
            {"b_name", name_json(result.names_b, one.label)},
            {"a_voxels", one.first_voxels},
            {"b_voxels", one.second_voxels},
            {"both_voxels", one.both_voxels},
            {"dice", one.dice()}};
  });
}

}  // namespace octavo::cli
