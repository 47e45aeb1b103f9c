#include "common/salvaging.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "text/quantities.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

constexpr std::size_t kMaxWarnings = 10;

bool is_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto parsed = std::from_chars(text.data(), end, value);
  return parsed.ec == std::errc{} && parsed.ptr == end && std::isfinite(value);
}

std::string fill_problem(const std::string& fill) {
  if (fill == "lowest" || fill == "coarse" || is_number(fill)) return "";
  return fmt::format("'{}' is neither lowest, coarse nor a number; name the file before --salvage",
                     escaped(fill));
}

/// The stored voxel nearest to a real value.
double stored_value(const FileReader& reader, const std::string& text) {
  const VolumeDescription& d = reader.description();
  const double real = parse_number(text, "--salvage");
  if (d.rescale.slope == 0) {
    throw Error(ErrorKind::invalid_argument,
                "--salvage: every voxel of this file stands for the same value; leave the number");
  }
  const double stored = (real - d.rescale.intercept) / d.rescale.slope;
  if (!is_integer(d.type)) return stored;
  const double nearest = std::round(stored);
  const ValueRange range = value_range(d.type);
  if (nearest >= static_cast<double>(range.min) && nearest <= static_cast<double>(range.max)) {
    return nearest;
  }
  const std::string unit = unit_of(metadata_of(d));
  const double a = d.rescale.to_real(static_cast<double>(range.min));
  const double b = d.rescale.to_real(static_cast<double>(range.max));
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--salvage {}: its voxels can be {} to {}{}", text,
                          number_text(std::min(a, b)), number_text(std::max(a, b)),
                          unit.empty() ? "" : " " + unit),
              reader.source().name());
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

std::string fill_text(const SalvagedDamage& damage, const FileReader& reader) {
  const VolumeDescription& d = reader.description();
  const bool is_one = damage.brick_count == 1;
  const std::string start =
      is_one ? "filled " : count_text(damage.brick_count) + " bricks filled ";
  if (damage.fill == SalvageFill::coarser_level) {
    return start + (is_one ? fmt::format("from level {}", damage.level) : "from coarser levels");
  }
  if (damage.fill == SalvageFill::brick_lowest && !is_one) {
    return start + "with their lowest values";
  }
  const std::string value = real_text(d, unit_of(metadata_of(d)), damage.value);
  switch (damage.fill) {
    case SalvageFill::brick_lowest: return start + "with its lowest value, " + value;
    case SalvageFill::volume_lowest:
      return start + "with the lowest value of the volume, " + value;
    default: return start + "with " + value;
  }
}

}  // namespace

void add_salvage_option(Verb verb, SalvageArguments& arguments) {
  verb.add_option_function<std::string>(
          "--salvage",
          [&arguments](const std::string& fill) {
            arguments.is_asked = true;
            arguments.fill = fill;
          },
          "Fill damaged bricks and name them in warnings instead of refusing: with their lowest "
          "value, with a value in real units, or 'coarse': from the next level that is whole")
      ->expected(0, 1)
      ->default_str("lowest")
      ->check({fill_problem, ""})
      ->type_name("[FILL]");
}

std::shared_ptr<const FileReader> salvaging(std::shared_ptr<const FileReader> reader,
                                            const SalvageArguments& arguments,
                                            const Context& context) {
  if (!arguments.is_asked) return reader;
  SalvageOptions options;
  options.from_coarser = arguments.fill == "coarse";
  if (is_number(arguments.fill)) options.value = stored_value(*reader, arguments.fill);
  if (context.strict) return reader;
  return std::make_shared<SalvageReader>(std::move(reader), options);
}

void read_or_hint(const SalvageArguments& arguments, const Context& context,
                  const std::function<void()>& read) {
  try {
    read();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::corrupt) throw;
    const char* hint = "; --salvage fills what is damaged";
    if (arguments.is_asked && !context.strict) throw;
    if (arguments.is_asked) hint = "; --strict forbids to fill it";
    throw Error(error.kind(), error.detail() + hint, error.path(), error.offset());
  }
}

void warn_of_salvaged(const FileReader& reader, Context& context) {
  const auto* salvage = dynamic_cast<const SalvageReader*>(&reader);
  if (salvage == nullptr) return;
  const SalvageReport report = salvage->report();
  const std::string name = escaped(reader.source().name()) + ": ";
  const std::size_t told = std::min(report.damages.size(), kMaxWarnings);
  for (std::size_t i = 0; i < told; ++i) {
    const SalvagedDamage& damage = report.damages[i];
    context.warn(name + damage.detail + ": " + fill_text(damage, reader));
  }
  const std::int64_t left = report.damage_count - static_cast<std::int64_t>(told);
  if (left == 0) return;
  context.warn(fmt::format("{}{} more damaged places; {} bricks were filled in all, verify names "
                           "each",
                           name, count_text(left), count_text(report.brick_count)));
}

nlohmann::ordered_json salvaged_json(const FileReader& reader) {
  const auto* salvage = dynamic_cast<const SalvageReader*>(&reader);
  if (salvage == nullptr) return nullptr;
  const SalvageReport report = salvage->report();
  nlohmann::ordered_json damages = nlohmann::ordered_json::array();
  for (const SalvagedDamage& damage : report.damages) {
    nlohmann::ordered_json object = {{"offset", damage.offset},
                                     {"detail", damage.detail},
                                     {"bricks", damage.brick_count},
                                     {"fill", fill_name(damage.fill)}};
    if (damage.fill == SalvageFill::coarser_level) {
      object["level"] = damage.level;
    } else {
      object["stored_value"] = damage.value;
    }
    damages.push_back(object);
  }
  return {{"bricks", report.brick_count},
          {"damage_count", report.damage_count},
          {"damages", damages}};
}

}  // namespace octavo::cli
