// octavo measure: volumes, places, shapes and grey values of labeled regions.
#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/part_options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/measure.h"
#include "octavo/tasks/structure/region_rows.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/table.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMeasureText = {
    "measure", "Measure the regions of a label map, and the grey values beneath them.",
    "For each label but 0, or for those of --label: voxels, mm3, surface voxels (with a face on\n"
    "something else), centroid, bounding box, principal moments and axes; with --of also mean,\n"
    "standard deviation, minimum, maximum, integrated value (sum times mm3) and percentiles of\n"
    "the grey volume, in its real units (HU); the table shows those percentiles that are asked\n"
    "for. Positions are in mm (LPS), of centroids in voxels too; boxes in voxels, half-open.\n\n"
    "--part I/N measures a part of large files, as a task of an array of N does, and writes\n"
    "what it found; --join, with the same options, says of all parts what measure says, to every\n"
    "digit. Parts give percentiles of values that span over at most 2^16.\n\n"
    "Examples:\n"
    "  octavo measure skull.8vo\n"
    "  octavo measure organs.8vo --of ct.8vo --csv > organs.csv\n"
    "  octavo measure organs.8vo --label liver --label 7\n"
    "  octavo measure organs.8vo --of ct.8vo --percentile 1 --percentile 99 --json"};

struct MeasureArguments {
  MeasureOptions options;
  std::vector<double> percentiles;  ///< in place of the usual ones, and in the table
  bool is_csv = false;
  PartArguments parts;
};

nlohmann::ordered_json region_json(const MeasuredRegion& region, const MeasureResult& result) {
  nlohmann::ordered_json object = json_of(facts_of(region_row(region, result)));
  object["name"] = name_json(result.names, region.region.label);
  return object;
}

std::string csv_value(const FactValue& value) {
  const nlohmann::ordered_json json = json_of(value);
  if (json.is_null()) return "";
  return json.is_string() ? csv_cell(json.get<std::string>()) : json.dump();
}

/// The names of the columns, and a line for each region; cells of what is not known are empty.
std::string csv_text(const MeasureResult& result, bool has_grey) {
  MeasuredRegion none;
  if (has_grey) none.region.grey.emplace().percentiles.resize(result.percentiles.size());
  std::vector<std::string> cells;
  for (const Fact& column : columns_of(region_row(none, result))) cells.push_back(column.name);
  std::string text = fmt::format("{}\n", fmt::join(cells, ","));
  for (const MeasuredRegion& region : result.regions) {
    cells.clear();
    for (const Fact& column : columns_of(region_row(region, result))) {
      cells.push_back(csv_value(column.value));
    }
    text += fmt::format("{}\n", fmt::join(cells, ","));
  }
  return text;
}

std::vector<std::string> cells_of(const MeasuredRegion& row, const std::string& name) {
  const RegionMeasure& r = row.region;
  std::vector<std::string> cells = {std::to_string(r.label),
                                    name,
                                    count_of(r.voxel_count),
                                    "-",
                                    count_of(r.surface_voxel_count),
                                    "-",
                                    "-"};
  const Point3& c = row.in_mm ? row.in_mm->centroid : r.centroid;
  cells[5] = fmt::format("{:.1f}, {:.1f}, {:.1f}", c[0], c[1], c[2]);
  if (row.in_mm) {
    const auto& m = row.in_mm->axes.moments_mm2;
    cells[3] = fmt::format("{:.2f}", row.in_mm->mm3);
    cells[6] =
        fmt::format("{:.2f}, {:.2f}, {:.2f}", std::sqrt(m[0]), std::sqrt(m[1]), std::sqrt(m[2]));
  }
  if (!r.grey) return cells;
  cells.insert(cells.end(),
               {fmt::format("{:.2f}", r.grey->mean), fmt::format("{:.2f}", r.grey->deviation),
                number_text(r.grey->minimum), number_text(r.grey->maximum)});
  for (const double value : r.grey->percentiles) cells.push_back(number_text(value));
  return cells;
}

std::string table_text(const MeasureResult& result, bool shows_percentiles) {
  const bool is_in_mm = result.regions.empty() || result.regions.front().in_mm.has_value();
  std::vector<TextColumn> columns = {{"label", 10},
                                     name_column(),
                                     {"voxels", 14},
                                     {"mm3", 14},
                                     {"surface", 12},
                                     {is_in_mm ? "centroid mm (x, y, z)" : "centroid voxels", 26,
                                      Align::left},
                                     {"principal sd mm", 24, Align::left}};
  const bool has_grey = !result.regions.empty() && result.regions.front().region.grey.has_value();
  if (has_grey) {
    columns.insert(columns.end(), {{"mean", 10}, {"sd", 9}, {"min", 9}, {"max", 9}});
    for (const double percent : result.percentiles) {
      if (shows_percentiles) columns.push_back({"p" + exact_text(percent), 9});
    }
    // Behind the heads alone: rows have no cell there.
    columns.push_back({result.unit, 0, Align::left});
  }
  TextTable table(columns);
  for (const MeasuredRegion& row : result.regions) {
    std::vector<std::string> cells = cells_of(row, result.names.name_of(row.region.label));
    cells.resize(columns.size() - (has_grey ? 1 : 0));
    cells.resize(columns.size());
    table.add(std::move(cells));
  }
  return table.text();
}

MeasureOptions options_of(const MeasureArguments& arguments) {
  MeasureOptions options = arguments.options;
  if (!arguments.percentiles.empty()) options.percentiles = arguments.percentiles;
  return options;
}

int run_measure_part(const MeasureArguments& arguments, Context& context) {
  const MeasurePartOptions options = {options_of(arguments), *arguments.parts.part,
                                      arguments.parts.output_of_part()};
  const std::size_t regions = run_task(measure_volume_part, options, context);
  print_part_result(context, options.output, options.part, {{"regions", regions}},
                    count_of(regions, "region"));
  return kExitDone;
}

MeasureResult measured(const MeasureArguments& arguments, Context& context) {
  if (arguments.parts.join.empty()) return run_task(measure, options_of(arguments), context);
  const JoinMeasuredOptions options = {options_of(arguments), arguments.parts.join};
  return run_task(join_measured, options, context);
}

int run_measure(const MeasureArguments& arguments, Context& context) {
  check_part_options(arguments.parts);
  if (arguments.is_csv && arguments.parts.part) {
    throw Error(ErrorKind::invalid_argument, "--csv goes with --join, not with --part");
  }
  if (arguments.is_csv && context.json) {
    throw Error(ErrorKind::invalid_argument, "--csv and --json do not go together; give one");
  }
  if (!arguments.percentiles.empty() && arguments.options.grey.empty()) {
    throw Error(ErrorKind::invalid_argument, "--percentile goes with --of GREY");
  }
  if (arguments.parts.part) return run_measure_part(arguments, context);
  const MeasureResult result = measured(arguments, context);
  if (arguments.is_csv) {
    print(csv_text(result, !arguments.options.grey.empty()));
    return kExitDone;
  }
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  if (context.json) {
    for (const MeasuredRegion& region : result.regions) {
      objects.push_back(region_json(region, result));
    }
  }
  print_result(context, {{"objects", objects}, {"unit", result.unit}},
               table_text(result, !arguments.percentiles.empty()));
  return kExitDone;
}

}  // namespace

void add_measure(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kMeasureText, run_measure);
  MeasureOptions& options = arguments.options;
  verb.add_option("labels FILE", options.labels, "A label map, .8vo").required();
  verb.add_option("--of GREY", options.grey, "The grey volume to measure under the labels, .8vo");
  add_label_option(verb, options.asked, "Measure this label alone");
  Option percentile = verb.add_list("--percentile P", arguments.percentiles,
                                    "A percentile, 0 to 100 (default 5, 25, 50, 75, 95)")
                          .check(number_within(0, 100));
  verb.add_flag_of("--no-percentiles", options.percentiles, {}, "Leave percentiles out")
      .excludes(percentile);
  verb.add_flag("--csv", arguments.is_csv, "One line per region, comma-separated");
  add_part_options(verb, arguments.parts);
}

}  // namespace octavo::cli
