// octavo morphometry: what labs of bone, rock and foam measure of a mask.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/structure/morphometry.h"
#include "octavo/tasks/structure/morphometry_rows.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMorphometryText = {
    "morphometry", "Measure structure: volume share, surface, thickness, connectivity and more.",
    "Bone volume and total volume (BV, TV, BV/TV), surface (BS, BS/BV), thickness, separation and\n"
    "number (Tb.Th, Tb.Sp, Tb.N) by the largest balls that fit, structure model index, Euler\n"
    "number and connectivity density, ellipsoid factor, degree of anisotropy, fractal dimension;\n"
    "with --tortuosity how much longer than straight the ways through pores are; with --of also\n"
    "densities of the tissue and of the total volume (TMD, BMD), calibrated where --calibration\n"
    "gives a line. Of rock and foam 1 - BV/TV is the porosity and Tb.Sp the size of pores. The\n"
    "definitions, with their sources, stand in docs/morphometry.md.\n\n"
    "The surface at the border of the volume is no surface, and nothing is known beyond it.\n"
    "--region measures within a label map; balls may reach out of it.\n\n"
    "Examples:\n"
    "  octavo morphometry bone.8vo\n"
    "  octavo morphometry bone.8vo --of scan.8vo --calibration 0.37,-120 --csv\n"
    "  octavo morphometry bone.8vo --region trabecular.8vo --thickness-map thickness.8vo\n"
    "  octavo morphometry cortex.8vo --slices --csv"};

struct MorphometryArguments {
  std::string input;
  std::string region;
  std::string grey;
  std::string calibration;
  std::string thickness_map;
  std::string spacing_map;
  std::string histogram;
  bool tortuosity = false;
  bool no_thickness = false;
  bool slices = false;
  bool csv = false;
};

nlohmann::ordered_json summary_json(const std::optional<ThicknessSummary>& summary) {
  if (!summary) return nullptr;
  return {{"voxels", summary->voxels},        {"mean_mm", summary->mean_mm},
          {"sd_mm", summary->deviation_mm},   {"min_mm", summary->minimum_mm},
          {"max_mm", summary->maximum_mm},    {"bin_mm", summary->bin_mm},
          {"bins", summary->bins}};
}

nlohmann::ordered_json report_json(const MorphometryArguments& arguments,
                                   const MorphometryResult& result) {
  nlohmann::ordered_json report = {{"mask", arguments.input}};
  for (const MorphometryRow& row : morphometry_rows(result, arguments.tortuosity)) {
    report[row.key] = optional_json(row.value);
  }
  report["thickness"] = summary_json(result.thickness);
  report["spacing"] = summary_json(result.spacing);
  report["ellipsoids"] = nullptr;
  if (const auto& e = result.ellipsoids) {
    report["ellipsoids"] = {{"count", e->ellipsoids}, {"shares", e->shares}};
  }
  report["mil"] = nullptr;
  if (const auto& a = result.anisotropy) {
    report["mil"] = {{"lengths_mm", a->lengths_mm}, {"axes", a->axes}};
  }
  nlohmann::ordered_json boxes = nlohmann::ordered_json::array();
  for (const BoxCount& one : result.boxes) {
    boxes.push_back({{"side", one.side}, {"holding", one.holding}, {"mixed", one.mixed}});
  }
  report["boxes"] = boxes;
  report["touches_border"] = result.touches;
  if (!arguments.slices) return report;
  nlohmann::ordered_json slices = nlohmann::ordered_json::array();
  const auto& spacing = result.volume.geometry.spacing_mm;
  for (const SliceMeasure& slice : result.slices) {
    slices.push_back({{"area_mm2", static_cast<double>(slice.voxels) * spacing[0] * spacing[1]},
                      {"total_mm2",
                       static_cast<double>(slice.region_voxels) * spacing[0] * spacing[1]},
                      {"thickness_mm", slice.mean_thickness_mm}});
  }
  report["slices"] = slices;
  return report;
}

std::string slices_csv(const MorphometryResult& result) {
  std::string text = "slice,area_mm2,total_mm2,thickness_mm\n";
  const auto& spacing = result.volume.geometry.spacing_mm;
  const double pixel = spacing[0] * spacing[1];
  for (std::size_t z = 0; z < result.slices.size(); ++z) {
    const SliceMeasure& slice = result.slices[z];
    text += fmt::format("{},{:.9g},{:.9g},{:.9g}\n", z, static_cast<double>(slice.voxels) * pixel,
                        static_cast<double>(slice.region_voxels) * pixel, slice.mean_thickness_mm);
  }
  return text;
}

std::string report_text(const MorphometryArguments& arguments, const MorphometryResult& result) {
  if (arguments.slices) return slices_csv(result);
  std::string text = arguments.csv ? "name,value,unit\n" : "";
  for (const MorphometryRow& row : morphometry_rows(result, arguments.tortuosity)) {
    if (arguments.csv) {
      const std::string value = row.value ? fmt::format("{:.9g}", *row.value) : "";
      text += fmt::format("{},{},{}\n", row.key, value, row.unit);
      continue;
    }
    const std::string value = row.value ? fmt::format("{:.6g}", *row.value) : "-";
    text += fmt::format("{:<10} {:>12} {:<6} {}\n", row.label, value, row.unit, row.words);
  }
  return text;
}

MorphometryOptions options_of(const MorphometryArguments& arguments, const Context& context) {
  MorphometryOptions options;
  options.input = arguments.input;
  options.region = arguments.region;
  options.grey = arguments.grey;
  options.has_thickness = !arguments.no_thickness;
  options.has_tortuosity = arguments.tortuosity;
  options.histogram = {arguments.histogram, context.force};
  options.thickness_map = {arguments.thickness_map, context.force};
  options.spacing_map = {arguments.spacing_map, context.force};
  if (arguments.calibration.empty()) return options;
  const std::vector<std::string> parts = split(arguments.calibration, ',');
  if (parts.size() != 2 || arguments.grey.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "--calibration takes SLOPE,INTERCEPT, for the scan that --of gives");
  }
  options.calibration = {parse_number(parts[0], "--calibration"),
                         parse_number(parts[1], "--calibration")};
  return options;
}

int run_morphometry(const MorphometryArguments& arguments, Context& context) {
  if (arguments.no_thickness &&
      (arguments.slices || !arguments.thickness_map.empty() || !arguments.spacing_map.empty() ||
       !arguments.histogram.empty())) {
    throw Error(ErrorKind::invalid_argument,
                "--no-thickness leaves out what --slices, --histogram and the maps show");
  }
  const MorphometryResult result = run_task(morphometry, options_of(arguments, context), context);
  print_result(context, report_json(arguments, result), report_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_morphometry(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<MorphometryArguments>();
  Verb verb = add_verb(app, context, kMorphometryText, [arguments, &context] {
    return run_morphometry(*arguments, context);
  });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("--region", arguments->region, "A label map to measure within")
      ->type_name("FILE");
  verb.add_option("--of", arguments->grey, "The scan on the same grid, for densities")
      ->type_name("GREY");
  verb.add_option("--calibration", arguments->calibration,
                  "Density = SLOPE * value + INTERCEPT, of the scan's real values")
      ->type_name("SLOPE,INTERCEPT");
  verb.add_option("--thickness-map", arguments->thickness_map, "An .8vo file of local thickness")
      ->type_name("FILE");
  verb.add_option("--spacing-map", arguments->spacing_map, "An .8vo file of local separation")
      ->type_name("FILE");
  verb.add_option("--histogram", arguments->histogram,
                  "A PNG of the histograms of thickness and separation")
      ->type_name("FILE");
  verb.add_flag("--tortuosity", arguments->tortuosity,
                "Geodesic tortuosity of what is not in the mask, along x, y and z");
  verb.add_flag("--no-thickness", arguments->no_thickness, "Leave out Tb.Th, Tb.Sp, Tb.N and EF");
  verb.add_flag("--slices", arguments->slices,
                "Area and mean thickness of each slice, as CSV or in --json");
  verb.add_flag("--csv", arguments->csv, "name,value,unit in place of a table");
}

}  // namespace octavo::cli
