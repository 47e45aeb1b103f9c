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

nlohmann::ordered_json row_json(const MeasuredRegion& row, const MeasureResult& result) {
  const RegionMeasure& r = row.region;
  const RegionInMm in_mm = row.in_mm.value_or(RegionInMm{});
  const auto if_in_mm = [&](const nlohmann::ordered_json& value) {
    return row.in_mm ? value : nlohmann::ordered_json(nullptr);
  };
  nlohmann::ordered_json object = {
      {"label", r.label},
      {"name", name_json(result.names, r.label)},
      {"voxels", r.voxel_count},
      {"mm3", if_in_mm(in_mm.mm3)},
      {"surface_voxels", r.surface_voxel_count},
      {"centroid_mm", if_in_mm(in_mm.centroid)},
      {"centroid_voxel", r.centroid},
      {"box", box_json(r.box)},
      {"principal_moments_mm2", if_in_mm(in_mm.axes.moments_mm2)},
      {"principal_axes", if_in_mm(in_mm.axes.axes)}};
  if (!r.grey) return object;
  object["mean"] = r.grey->mean;
  object["sd"] = r.grey->deviation;
  object["min"] = r.grey->minimum;
  object["max"] = r.grey->maximum;
  object["integrated_mm3"] = optional_json(in_mm.integrated);
  if (result.percentiles.empty()) return object;
  nlohmann::ordered_json& of_percent = object["percentiles"];
  for (std::size_t i = 0; i < result.percentiles.size(); ++i) {
    of_percent[number_text(result.percentiles[i])] = r.grey->percentiles[i];
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

std::string csv_value(const nlohmann::ordered_json& value) {
  if (value.is_null()) return "";
  return value.is_string() ? csv_cell(value.get<std::string>()) : value.dump();
}

/// The objects as a table with one column per number: what is a list in JSON has a column each;
/// cells of what is not known are empty.
/// head  an object for the names of the columns
std::string csv_text(const nlohmann::ordered_json& head, const nlohmann::ordered_json& objects) {
  const auto name_of = [](std::string pointer) {
    // Where a list is one of axes, its places are called by them.
    constexpr const char* kAxes[] = {"_x", "_y", "_z"};
    constexpr const char* kEnds[] = {"_lo", "_hi"};
    std::vector<std::string> parts = split(pointer.substr(1), '/');
    const auto place = [&](std::size_t i) { return static_cast<std::size_t>(parts[i][0] - '0'); };
    if (parts[0] == "centroid_mm") return std::string("centroid") + kAxes[place(1)] + "_mm";
    if (parts[0] == "centroid_voxel") return std::string("centroid") + kAxes[place(1)] + "_voxel";
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
  const auto add_line = [&](const nlohmann::ordered_json& object, const auto& cell_of) {
    std::string line;
    const nlohmann::ordered_json flat = with_all_places(object).flatten();
    for (const auto& [pointer, value] : flat.items()) {
      line += (line.empty() ? "" : ",") + cell_of(pointer, value);
    }
    text += line + "\n";
  };
  add_line(head, [&](const std::string& pointer, const auto&) { return name_of(pointer); });
  for (const auto& object : objects) {
    add_line(object, [](const std::string&, const auto& value) { return csv_value(value); });
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
      if (shows_percentiles) columns.push_back({"p" + number_text(percent), 9});
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
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  if (context.json || arguments.is_csv) {
    for (const MeasuredRegion& row : result.regions) {
      objects.push_back(row_json(row, result));
    }
  }
  if (arguments.is_csv && !context.json) {
    MeasuredRegion none;
    if (!arguments.options.grey.empty()) {
      none.region.grey.emplace().percentiles.resize(result.percentiles.size());
    }
    print(csv_text(row_json(none, result), objects));
  } else {
    print_result(context, {{"objects", objects}, {"unit", result.unit}},
                 table_text(result, !arguments.percentiles.empty()));
  }
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
