#include "common/salvage_option.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "octavo/core/error.h"
#include "text/fact_json.h"
#include "text/offered_words.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

bool is_finite_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  return parsed.ec == std::errc{} && parsed.ptr == end && std::isfinite(value);
}

std::string fill_problem(const std::string& fill) {
  if (fill == kLowest || fill == kCoarse || is_finite_number(fill)) return "";
  return fmt::format("'{}' is neither lowest, coarse nor a number; name the file before --salvage",
                     escaped(fill));
}

const char* fill_name(SalvageFill fill) {
  switch (fill) {
    case SalvageFill::value: return "value";
    case SalvageFill::brick_lowest: return "brick_lowest";
    case SalvageFill::volume_lowest: return "volume_lowest";
    case SalvageFill::coarser_level: return "coarser_level";
  }
  return "";
}

}  // namespace

void add_salvage_option(Verb verb, std::optional<SalvageFilling>& filling) {
  verb.add_option_function(
          "--salvage [FILL]",
          [&filling](const std::string& fill) {
            filling.emplace().is_from_coarser = fill == kCoarse;
            if (is_finite_number(fill)) filling->real_value = parse_number(fill, "--salvage");
          },
          "Fill damaged bricks and name them in warnings instead of refusing: with their lowest "
          "value, with a value in real units, or 'coarse': from the next level that is whole")
      .expected(0, 1)
      .default_str(std::string(kLowest))
      .check({fill_problem, ""});
}

nlohmann::ordered_json salvaged_json(const std::optional<SalvageReport>& report) {
  if (!report) return nullptr;
  const auto damage_json = [](const SalvagedDamage& damage) {
    nlohmann::ordered_json object = {{"offset", damage.offset},
                                     {"detail", damage.detail},
                                     {"bricks", damage.brick_count},
                                     {"fill", fill_name(damage.fill)}};
    if (damage.fill == SalvageFill::coarser_level) {
      object["level"] = damage.level;
    } else {
      object["stored_value"] = damage.value;
    }
    return object;
  };
  return {{"bricks", report->brick_count},
          {"damage_count", report->damage_count},
          {"damages", json_list(report->damages, damage_json)}};
}

}  // namespace octavo::cli
