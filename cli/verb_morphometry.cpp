// octavo morphometry: what labs of bone, rock and foam measure of a mask.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/structure/morphometry.h"
#include "octavo/tasks/structure/morphometry_rows.h"
#include "text/fact_json.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kMorphometryText = {
    "morphometry", "Measure structure: volume share, surface, thickness, connectivity and more.",
    "Bone volume and total volume (BV, TV, BV/TV), surface (BS, BS/BV), thickness, separation and\n"
    "number (Tb.Th, Tb.Sp, Tb.N) by the largest balls that fit, structure model index, Euler\n"
    "number and connectivity density, ellipsoid factor, degree of anisotropy, fractal dimension;\n"
    "with --tortuosity how much longer than straight the ways through pores are, with --diffusion\n"
    "how much slower things spread through them; with --of also densities of the tissue and of\n"
    "the total volume (TMD, BMD), calibrated where --calibration gives a line. Of rock and foam\n"
    "1 - BV/TV is the porosity and Tb.Sp the size of pores. The definitions, with their sources,\n"
    "stand in docs/morphometry.md.\n\n"
    "The surface at the border of the volume is no surface, and nothing is known beyond it.\n"
    "--region measures within a label map; balls may reach out of it, and pores are followed from\n"
    "one end of it to the other.\n\n"
    "Examples:\n"
    "  octavo morphometry bone.8vo\n"
    "  octavo morphometry bone.8vo --of scan.8vo --calibration 0.37,-120 --csv\n"
    "  octavo morphometry bone.8vo --region trabecular.8vo --thickness-map thickness.8vo\n"
    "  octavo morphometry cortex.8vo --slices --csv"};

struct MorphometryArguments {
  MorphometryOptions options;
  std::optional<Rescale> calibration;
  bool has_slices = false;
  bool is_csv = false;
};

Rescale parse_calibration(const std::string& text, const std::string& option) {
  const std::vector<double> numbers = parse_numbers(text, option, 2, "SLOPE,INTERCEPT");
  return {numbers[0], numbers[1]};
}

nlohmann::ordered_json report_json(const MorphometryArguments& arguments,
                                   const MorphometryResult& result) {
  nlohmann::ordered_json report = {{"mask", public_name(arguments.options.input)}};
  report.update(json_of(morphometry_facts(result, arguments.options.has_tortuosity)));
  if (!arguments.has_slices) return report;
  report["slices"] = json_of(slice_facts(result));
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
  if (arguments.has_slices) return slices_csv(result);
  std::string text = arguments.is_csv ? "name,value,unit\n" : "";
  for (const MorphometryRow& row : morphometry_rows(result, arguments.options.has_tortuosity)) {
    if (arguments.is_csv) {
      const std::string value = row.value ? fmt::format("{:.9g}", *row.value) : "";
      text += fmt::format("{},{},{}\n", row.key, value, row.unit);
      continue;
    }
    const std::string value = row.value ? fmt::format("{:.6g}", *row.value) : "-";
    text += fmt::format("{:<10} {:>12} {:<6} {}\n", row.label, value, row.unit, row.words);
  }
  return text;
}

MorphometryOptions checked_options(const MorphometryArguments& arguments) {
  MorphometryOptions options = arguments.options;
  if (arguments.calibration && options.grey.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "--calibration takes SLOPE,INTERCEPT, for the scan that --of gives");
  }
  options.calibration = arguments.calibration.value_or(options.calibration);
  const bool shows_thickness = arguments.has_slices || !options.thickness_map.path.empty() ||
                               !options.spacing_map.path.empty() || !options.histogram.path.empty();
  if (shows_thickness && !options.has_thickness) {
    throw Error(ErrorKind::invalid_argument,
                "--no-thickness leaves out what --slices, --histogram and the maps show");
  }
  return options;
}

int run_morphometry(const MorphometryArguments& arguments, Context& context) {
  if (arguments.is_csv && context.json) {
    throw Error(ErrorKind::invalid_argument, "--csv and --json do not go together; give one");
  }
  const MorphometryResult result = run_task(morphometry, checked_options(arguments), context);
  print_result(context, report_json(arguments, result), report_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_morphometry(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kMorphometryText, run_morphometry);
  MorphometryOptions& options = arguments.options;
  add_mask_input(verb, options.input);
  verb.add_option("--region FILE", options.region, "A label map to measure within");
  verb.add_option("--of GREY", options.grey, "The scan on the same grid, for densities");
  verb.add_parsed("--calibration SLOPE,INTERCEPT", arguments.calibration, parse_calibration,
                  "Density = SLOPE * value + INTERCEPT, of the scan's real values");
  verb.add_output_option("--thickness-map FILE", options.thickness_map,
                         "An .8vo file of local thickness");
  verb.add_output_option("--spacing-map FILE", options.spacing_map,
                         "An .8vo file of local separation");
  verb.add_output_option("--histogram FILE", options.histogram,
                         "A PNG of the histograms of thickness and separation");
  verb.add_flag("--tortuosity", options.has_tortuosity,
                "Geodesic tortuosity of what is not in the mask, along x, y and z");
  verb.add_flag("--diffusion", options.has_diffusion,
                "Effective diffusivity and diffusive tortuosity of it");
  verb.add_off_flag("--no-thickness", options.has_thickness, "Leave out Tb.Th, Tb.Sp, Tb.N and EF");
  verb.add_flag("--slices", arguments.has_slices,
                "Area and mean thickness of each slice, as CSV or in --json");
  verb.add_flag("--csv", arguments.is_csv, "name,value,unit in place of a table");
}

}  // namespace octavo::cli
