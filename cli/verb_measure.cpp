// octavo measure: volumes, places, shapes and grey values of labeled regions.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/progress_line.h"
#include "octavo/ops/measure/measure.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "measure", "Measure the regions of a label map, and the grey values beneath them.",
    "For each label but 0: voxels, mm3, surface voxels (with a face on something else),\n"
    "centroid, bounding box, principal moments and axes; with --of also mean, standard\n"
    "deviation, least, greatest, integrated value (sum times mm3) and percentiles of the grey\n"
    "volume, in its real units (HU); the table shows those percentiles that are asked for.\n"
    "Positions are in mm (LPS), boxes in voxels, half-open.\n\n"
    "Examples:\n"
    "  octavo measure skull.8vo\n"
    "  octavo measure organs.8vo --of ct.8vo --csv > organs.csv\n"
    "  octavo measure organs.8vo --of ct.8vo --percentile 1 --percentile 99 --json"};

struct Arguments {
  std::string input;
  std::string grey;
  std::vector<double> percentiles;
  bool csv = false;
};

/// Grey statistics in real units.
GreyStatistics real_statistics(const GreyStatistics& stored, const Rescale& rescale,
                               std::uint64_t voxels) {
  GreyStatistics real;
  real.mean = rescale.to_real(stored.mean);
  real.deviation = std::abs(rescale.slope) * stored.deviation;
  real.least = rescale.to_real(stored.least);
  real.greatest = rescale.to_real(stored.greatest);
  if (rescale.slope < 0) std::swap(real.least, real.greatest);
  real.sum = rescale.slope * stored.sum + rescale.intercept * static_cast<double>(voxels);
  for (const double value : stored.percentiles) real.percentiles.push_back(rescale.to_real(value));
  return real;
}

/// One region with all that is said of it.
struct Row {
  RegionMeasure region;
  std::optional<double> mm3;  ///< nothing, as all in mm, where the spacing is not known
  Point3 centroid_mm{};
  PrincipalAxes axes;
};

std::vector<Row> rows_of(std::vector<RegionMeasure> regions, const VolumeDescription& labels,
                         const VolumeDescription* grey) {
  const auto mm3_of_one = voxel_mm3(labels);
  std::vector<Row> rows;
  for (RegionMeasure& region : regions) {
    Row row;
    if (mm3_of_one) row.mm3 = static_cast<double>(region.voxel_count) * *mm3_of_one;
    row.centroid_mm = labels.geometry.to_world(region.centroid);
    row.axes = principal_axes(region, labels.geometry);
    if (region.grey) {
      region.grey = real_statistics(*region.grey, grey->rescale, region.voxel_count);
    }
    row.region = std::move(region);
    rows.push_back(std::move(row));
  }
  return rows;
}

/// The percentiles from low to high, of values on a falling scale as well.
std::vector<double> asked_percentiles(const Arguments& arguments) {
  std::vector<double> percentiles =
      arguments.percentiles.empty() ? MeasureOptions().percentiles : arguments.percentiles;
  for (const double percent : percentiles) {
    if (percent >= 0 && percent <= 100) continue;
    throw Error(ErrorKind::invalid_argument, "--percentile: must be 0 to 100");
  }
  std::sort(percentiles.begin(), percentiles.end());
  percentiles.erase(std::unique(percentiles.begin(), percentiles.end()), percentiles.end());
  return percentiles;
}

nlohmann::ordered_json row_json(const Row& row, const std::vector<double>& percentiles) {
  const RegionMeasure& r = row.region;
  const auto in_mm = [&](const nlohmann::ordered_json& value) {
    return row.mm3 ? value : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json object = {
      {"label", r.label},
      {"voxels", r.voxel_count},
      {"mm3", in_mm(row.mm3.value_or(0))},
      {"surface_voxels", r.surface_voxel_count},
      {"centroid_mm", in_mm(row.centroid_mm)},
      {"box", {{r.box.lo.x, r.box.hi.x}, {r.box.lo.y, r.box.hi.y}, {r.box.lo.z, r.box.hi.z}}},
      {"principal_moments_mm2", in_mm(row.axes.moments_mm2)},
      {"principal_axes", in_mm(row.axes.axes)}};
  if (!r.grey) return object;
  object["mean"] = r.grey->mean;
  object["sd"] = r.grey->deviation;
  object["min"] = r.grey->least;
  object["max"] = r.grey->greatest;
  object["integrated_mm3"] = in_mm(r.grey->mean * row.mm3.value_or(0));
  nlohmann::ordered_json& of_percent = object["percentiles"];
  for (std::size_t i = 0; i < percentiles.size(); ++i) {
    of_percent[number_text(percentiles[i])] = r.grey->percentiles[i];
  }
  return object;
}

/// The object of row_json with a place for every number, those that are not known as well.
nlohmann::ordered_json with_all_places(nlohmann::ordered_json object) {
  if (!object["centroid_mm"].is_null()) return object;
  const nlohmann::ordered_json unknown(3, nullptr);
  object["centroid_mm"] = unknown;
  object["principal_moments_mm2"] = unknown;
  object["principal_axes"] = nlohmann::ordered_json(3, unknown);
  return object;
}

/// The objects as a table with one column per number: what is a list in JSON has a column each;
/// cells of what is not known are empty.
std::string csv_text(const nlohmann::ordered_json& objects) {
  const auto name_of = [](std::string pointer) {
    // Where a list is one of axes, its places are called by them.
    constexpr const char* kAxes[] = {"_x", "_y", "_z"};
    constexpr const char* kEnds[] = {"_lo", "_hi"};
    std::vector<std::string> parts = split(pointer.substr(1), '/');
    const auto place = [&](std::size_t i) { return static_cast<std::size_t>(parts[i][0] - '0'); };
    if (parts[0] == "centroid_mm") return std::string("centroid") + kAxes[place(1)] + "_mm";
    if (parts[0] == "box") return std::string("box") + kAxes[place(1)] + kEnds[place(2)];
    if (parts[0] == "principal_axes") {
      return fmt::format("principal_axis_{}{}", place(1) + 1, kAxes[place(2)]);
    }
    if (parts[0] == "principal_moments_mm2") {
      return fmt::format("principal_moment_{}_mm2", place(1) + 1);
    }
    return parts.size() == 2 ? "p" + parts[1] : parts[0];
  };
  std::string text;
  for (const auto& object : objects) {
    std::string names;
    std::string values;
    const nlohmann::ordered_json flat = with_all_places(object).flatten();
    for (const auto& [pointer, value] : flat.items()) {
      values += (names.empty() ? "" : ",") + (value.is_null() ? "" : value.dump());
      names += (names.empty() ? "" : ",") + name_of(pointer);
    }
    if (text.empty()) text = names + "\n";
    text += values + "\n";
  }
  return text;
}

/// percentiles  columns of the table; none where none were asked for
std::string table_text(const std::vector<Row>& rows, const std::vector<double>& percentiles,
                       const std::string& unit) {
  const bool has_grey = !rows.empty() && rows.front().region.grey.has_value();
  std::string text = fmt::format("{:>10} {:>14} {:>14} {:>12}  {:<26} {:<24}", "label", "voxels",
                                 "mm3", "surface", "centroid mm (x, y, z)", "principal sd mm");
  if (has_grey) {
    text += fmt::format(" {:>10} {:>9} {:>9} {:>9}", "mean", "sd", "min", "max");
    for (const double percent : percentiles) {
      text += fmt::format(" {:>9}", "p" + number_text(percent));
    }
    if (!unit.empty()) text += "  " + unit;
  }
  text += "\n";
  for (const Row& row : rows) {
    const RegionMeasure& r = row.region;
    const auto& c = row.centroid_mm;
    const auto& m = row.axes.moments_mm2;
    text += fmt::format(
        "{:>10} {:>14} {:>14} {:>12}  {:<26} {:<24}", r.label,
        count_text(static_cast<std::int64_t>(r.voxel_count)),
        row.mm3 ? fmt::format("{:.2f}", *row.mm3) : "-",
        count_text(static_cast<std::int64_t>(r.surface_voxel_count)),
        row.mm3 ? fmt::format("{:.1f}, {:.1f}, {:.1f}", c[0], c[1], c[2]) : "-",
        row.mm3 ? fmt::format("{:.2f}, {:.2f}, {:.2f}", std::sqrt(m[0]), std::sqrt(m[1]),
                              std::sqrt(m[2]))
                : "-");
    if (has_grey) {
      text += fmt::format(" {:>10.2f} {:>9.2f} {:>9} {:>9}", r.grey->mean, r.grey->deviation,
                          number_text(r.grey->least), number_text(r.grey->greatest));
      for (std::size_t i = 0; i < percentiles.size(); ++i) {
        text += fmt::format(" {:>9}", number_text(r.grey->percentiles[i]));
      }
    }
    text += "\n";
  }
  return text;
}

int run_measure(const Arguments& arguments, Context& context) {
  const std::shared_ptr<const FileReader> labels = open_octavo(arguments.input, context);
  if (labels->description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument,
                "holds grey values, not labels; 'octavo threshold' makes labels of it",
                arguments.input);
  }
  std::shared_ptr<const FileReader> grey;
  if (!arguments.grey.empty()) {
    grey = open_octavo(arguments.grey, context);
    require_same_grid(labels->description(), arguments.input, grey->description(), arguments.grey);
    if (grey->description().kind == VolumeKind::labels) {
      throw Error(ErrorKind::invalid_argument,
                  "holds labels, not grey values; --of takes the scan that was thresholded",
                  arguments.grey);
    }
  }
  const std::vector<double> percentiles = asked_percentiles(arguments);
  MeasureOptions options;
  options.percentiles = percentiles;
  // On a falling scale the p-th percentile is the (100 - p)-th stored one.
  if (grey && grey->description().rescale.slope < 0) {
    for (double& percent : options.percentiles) percent = 100 - percent;
  }
  if (!voxel_mm3(labels->description())) {
    context.warn(arguments.input +
                 ": its spacing is not known, so nothing is given in mm; build it with --spacing");
  }
  // A brick with its labels widened per thread, and the sums of 64 bricks.
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  require_memory((64 + 12 * static_cast<std::uint64_t>(context.thread_count())) * kMiB,
                 "measurements", context);
  std::vector<RegionMeasure> regions;
  {
    ProgressLine progress(context);
    on_threads(context, [&] {
      regions = measure_regions(*labels, grey.get(), options, progress);
    });
  }
  const std::vector<Row> rows =
      rows_of(std::move(regions), labels->description(), grey ? &grey->description() : nullptr);
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const Row& row : rows) {
    objects.push_back(row_json(row, percentiles));
  }
  const std::string unit = grey ? unit_of(metadata_of(grey->description())) : "";
  if (context.json) {
    print_json({{"objects", objects}, {"unit", unit}, {"warnings", context.warnings}});
  } else if (arguments.csv) {
    print(csv_text(objects));
  } else if (!context.quiet) {
    const bool is_asked = !arguments.percentiles.empty();
    print(table_text(rows, is_asked ? percentiles : std::vector<double>(), unit));
  }
  return kExitDone;
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_measure(*arguments, context); });
  verb.add_option("labels", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("--of", arguments->grey, "The grey volume to measure under the labels, .8vo")
      ->type_name("GREY");
  verb.add_option("--percentile", arguments->percentiles,
                  "A percentile, 0 to 100 (default 5, 25, 50, 75, 95)")
      ->type_name("P")
      ->allow_extra_args(false)
      ->check(number_within(0, 100));
  verb.add_flag("--csv", arguments->csv, "One line per region, comma-separated");
}

}  // namespace octavo::cli
