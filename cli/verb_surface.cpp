// octavo surface: a surface as triangles, for printers, solvers and viewers.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/surface.h"
#include "octavo/tasks/surfaces/label_surfaces.h"
#include "octavo/tasks/surfaces/surface_report.h"
#include "octavo/tasks/volume_facts.h"
#include "text/label_surface_words.h"
#include "text/offered_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kSurfaceText = {
    "surface", "Make a surface of triangles: STL, PLY, OBJ, GLB, VTP or 3MF.",
    "Of grey values the surface of what is at or above --isovalue, in real units (HU); of a label\n"
    "map that of --label, or of every voxel but 0. It is closed, also where the volume ends, and\n"
    "manifold, with triangles outward; both are proven before anything is written, and a surface\n"
    "that is not gives exit code 1 and the counts. Coordinates are mm in LPS, or with --space ras\n"
    "in RAS. Bricks whose minimum and maximum decide are not decoded. NaN and infinities lie\n"
    "outside. A mask ends at the sides of its voxels, and its edges and corners are cut: thin\n"
    "objects lose most, a single voxel five sixths of its volume. Grey values end at the middles\n"
    "of the outer voxels. Volumes come from octavo measure. But for STL and 3MF, files have\n"
    "normals: of grey values from their gradient. GLB has axes of its own, y up, and meters; its\n"
    "points have 16 bits where --max-deviation has room for their steps. 3MF moves all\n"
    "objects together until their lower corner is at 0,0,0, where printers have their plate;\n"
    "other formats keep the place of the scan.\n\n"
    "--seed follows the piece of the surface there from brick to brick: those that it does not\n"
    "pass are not decoded, and how many were is said.\n\n"
    "The surface has few triangles, by what --max-deviation allows: every point of it lies within\n"
    "that distance of the full one, and every point of that one within it of the surface, which\n"
    "is proven. It is in mm, or as 0.5voxel in shortest sides of a voxel. Pieces and handles\n"
    "stay, and no triangles cross. With --max-deviation 0 all triangles stay, which takes less\n"
    "time and memory.\n\n"
    "--method octree merges cells of an octree within the same deviation, proven alike, instead\n"
    "of collapsing edges; there are more triangles, at most as long as 32 voxels or so.\n\n"
    "--triangles asks for a number, or for a share of all as 5%: half a voxel of deviation is\n"
    "tried first, which may allow fewer, and then more and more until there are so many or less.\n"
    "The deviation that comes of it is proven and printed. Fewer than pieces and handles need are\n"
    "rejected, with the fewest that were reached. With --parts and --interfaces they are those\n"
    "between labels, each counted once.\n\n"
    "--parts makes the surface of each label of a map, all from the same triangles between them:\n"
    "neighbors fit without gaps or overlaps. A folder for -o gets a file for each, named\n"
    "after the label; --part-format says which. With a .ply, .obj, .glb, .vtp or .3mf file all\n"
    "go into that one. --interfaces writes each triangle once, with the labels inside and outside\n"
    "of it, to a .ply, .obj or .vtp file; lines where three labels meet are no manifold. Points\n"
    "move by half a voxel along each axis at most to be smooth, and less where the volume of a\n"
    "label would change by more than 1 %; --smooth off keeps the sides of voxels. Where a label\n"
    "touches itself at an edge or a point, points of its surface are moved apart, by about a\n"
    "hundredth of a voxel, so that programs which join points, as of STL, find it closed.\n"
    "Lines where three labels meet stay as they are, so that parts fit. Fewer triangles may\n"
    "change volumes by more than 1 %, of which a warning tells.\n\n"
    "Examples:\n"
    "  octavo surface head.8vo --isovalue 226 -o bone.stl\n"
    "  octavo surface head.8vo --isovalue 226 --max-deviation 1 -o light.stl\n"
    "  octavo surface head.8vo --isovalue 226 --max-deviation 0 -o full.stl\n"
    "  octavo surface head.8vo --isovalue 226 --triangles 5% -o preview.glb\n"
    "  octavo surface head.8vo --isovalue 226 -o bone.3mf --report bone.json\n"
    "  octavo surface head.8vo --isovalue 226 --level 1 --seed 64,20,27 -o skull.ply\n"
    "  octavo surface organs.8vo --label liver -o liver.obj --space ras\n"
    "  octavo surface organs.8vo --parts -o organs\n"
    "  octavo surface organs.8vo --parts --smooth off --label liver --label spleen -o two.3mf\n"
    "  octavo surface organs.8vo --interfaces -o organs.vtp"};

struct SurfaceArguments {
  SurfaceOptions options;
  std::optional<DecimationMethod> method;
  // Of surfaces between labels, which take some of the options above as well.
  bool are_parts = false;
  bool are_interfaces = false;
  std::optional<MeshFormat> part_format;
  std::optional<int> smoothing_steps;
};

/// "0.3" in mm, "0.5voxel".
AskedDeviation parse_deviation(const std::string& text, const std::string& option) {
  constexpr std::string_view kVoxel = "voxel";
  const bool is_in_voxels = text.ends_with(kVoxel);
  const std::string number = is_in_voxels ? text.substr(0, text.size() - kVoxel.size()) : text;
  return {parse_number(number, option), is_in_voxels};
}

/// "20000", "5%".
AskedTriangles parse_triangles(const std::string& text, const std::string& option) {
  const bool is_percent = text.ends_with('%');
  const std::string number = is_percent ? text.substr(0, text.size() - 1) : text;
  return {parse_number(number, option), is_percent};
}

/// "off", "20".
int parse_smoothing(const std::string& text, const std::string& option) {
  constexpr std::int64_t kMostSteps = 1000;
  const std::int64_t steps = text == kOff ? 0 : parse_integer(text, option);
  if (steps < 0 || steps > kMostSteps) {
    throw Error(ErrorKind::invalid_argument, option + " takes off, or 1 to 1000 steps");
  }
  return static_cast<int>(steps);
}

[[noreturn]] void reject_option(const std::string& option, const std::string& advice) {
  throw Error(ErrorKind::invalid_argument, option + " does not go with these: " + advice);
}

/// Proves that none is given that the other kind of surface takes.
void check_label_options(const SurfaceArguments& arguments) {
  const SurfaceOptions& options = arguments.options;
  const std::string of_labels = "leave it out, or give --parts";
  const std::string of_all = "leave it out, or --parts and --interfaces";
  if (!arguments.are_parts && !arguments.are_interfaces) {
    const bool has_cells = arguments.method == DecimationMethod::cells;
    if (has_cells && options.max_deviation.amount == 0) {
      reject_option("--method octree",
                    "leave it out, or --max-deviation 0, which keeps all triangles");
    }
    if (arguments.smoothing_steps) reject_option("--smooth", of_labels);
    if (arguments.part_format) reject_option("--part-format", of_labels);
    return;
  }
  if (options.isovalue) reject_option("--isovalue", of_all);
  if (options.is_stored) reject_option("--stored", of_all);
  if (options.is_plain) reject_option("--plain", of_all);
  if (options.allows_faults) reject_option("--allow-open", of_all);
  if (!options.report_path.empty()) reject_option("--report", of_all);
  if (options.seed) reject_option("--seed", of_all);
  if (arguments.method) reject_option("--method", of_all);
  if (arguments.part_format && (arguments.are_interfaces || mesh_format_of(options.output.path))) {
    reject_option("--part-format", "it is of files in a folder, which -o names");
  }
}

LabelSurfacesOptions label_options_of(const SurfaceArguments& arguments) {
  const SurfaceOptions& shared = arguments.options;
  LabelSurfacesOptions options;
  options.input = shared.input;
  options.output = shared.output;
  if (arguments.are_interfaces) options.form = LabelSurfaceForm::interfaces;
  options.part_format = arguments.part_format.value_or(options.part_format);
  options.labels = shared.labels;
  options.level = shared.level;
  options.smoothing_steps = arguments.smoothing_steps.value_or(options.smoothing_steps);
  options.max_deviation = shared.max_deviation;
  options.triangles = shared.triangles;
  options.space = shared.space;
  return options;
}

std::string all_fault_words(const SurfaceResult& result) {
  return fmt::format("{}, {} triangles that cross", fault_words(result.check),
                     result.crossing_triangles.value_or(0));
}

/// What helps against points at one place, where nothing else is at fault than triangles that cross
/// there: rounding made them.
std::string advice_words(const SurfaceResult& result) {
  const MeshCheck& check = result.check;
  const bool has_others = check.open_sides > 0 || check.repeated_sides > 0 ||
                          check.pinched_points > 0;
  if (has_others || check.coincident_points == 0) return "";
  double farthest = 0;
  for (const MeshPoint& corner : result.bounds_mm) {
    for (const float place : corner) farthest = std::max(farthest, std::abs(double{place}));
  }
  const double step = farthest - std::nextafter(static_cast<float>(farthest), 0.0f);
  return fmt::format(
      "coordinates are float32, whose steps are {:.2g} mm at {:.6g} mm from 0: so far away they\n"
      "cannot be told apart; a volume whose origin is nearer to 0 helps\n",
      step, farthest);
}

std::string report_text(const SurfaceOptions& options, const SurfaceResult& result) {
  if (!result.is_written) {
    return fmt::format("{}: not written, the surface has {}; --allow-open writes it\n",
                       shown_path(options.output.path), all_fault_words(result)) +
           advice_words(result);
  }
  std::string text =
      fmt::format("{}: {}, {}\n", shown_path(options.output.path),
                  count_of(result.triangle_count, "triangle"),
                  count_of(result.check.components, "piece"));
  text += result.is_sound ? "closed, manifold\n" : all_fault_words(result) + "\n";
  if (result.max_deviation_mm > 0) {
    text += fmt::format("{:.3g} % of {}, proven within {:.4g} mm\n",
                        100 * static_cast<double>(result.triangle_count) /
                            static_cast<double>(result.full_triangle_count),
                        count_of(result.full_triangle_count, "triangle"),
                        result.max_deviation_mm);
  }
  if (result.decoded_bricks) {
    text += fmt::format("the piece of the seed, out of {}\n",
                        count_of(*result.decoded_bricks, "brick"));
  }
  if (is_spacing_known(result.volume)) {
    text += fmt::format("area {:.6g} mm2, volume {:.6g} mm3\n", result.measures.area_mm2,
                        result.measures.volume_mm3);
  }
  return text;
}

nlohmann::ordered_json report_json(const SurfaceOptions& options, const SurfaceResult& result) {
  nlohmann::ordered_json json = {{"output", options.output.path},
                                 {"is_written", result.is_written},
                                 {"file_bytes", result.file_bytes}};
  json.update(json_of(surface_report(options, result)));
  if (result.decoded_bricks) json["decoded_bricks"] = *result.decoded_bricks;
  return json;
}

int run_label_surfaces(const SurfaceArguments& arguments, Context& context) {
  const LabelSurfacesOptions options = label_options_of(arguments);
  const LabelSurfacesResult result = run_task(label_surfaces, options, context);
  print_finding(context, result.is_written, label_surfaces_json(options, result),
                label_surfaces_text(options, result));
  return result.is_written ? kExitDone : kExitDifferent;
}

int run_surface(const SurfaceArguments& arguments, Context& context) {
  check_label_options(arguments);
  if (arguments.are_parts || arguments.are_interfaces) {
    return run_label_surfaces(arguments, context);
  }
  SurfaceOptions options = arguments.options;
  options.method = arguments.method.value_or(options.method);
  const SurfaceResult result = run_task(surface, options, context);
  print_finding(context, result.is_written, report_json(options, result),
                report_text(options, result));
  return result.is_written ? kExitDone : kExitDifferent;
}

void add_label_surface_options(Verb verb, SurfaceArguments& arguments) {
  Option parts = verb.add_flag("--parts", arguments.are_parts,
                               "Of a label map a closed part for each label, that fit each other");
  verb.add_flag("--interfaces", arguments.are_interfaces,
                "Of a label map all surfaces between labels, with the labels on both sides")
      .excludes(parts);
  verb.add_word("--part-format FORMAT", arguments.part_format,
                "With --parts: the format of files in a folder (default: stl)");
  verb.add_parsed("--smooth N|off", arguments.smoothing_steps, parse_smoothing,
                  "With --parts or --interfaces: steps of smoothing, or off (default: 20)");
}

}  // namespace

void add_surface(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kSurfaceText, run_surface);
  SurfaceOptions& options = arguments.options;
  options.max_deviation = {0.5, true};
  verb.add_input(options.input);
  verb.add_output(options.output,
                  "The .stl, .ply, .obj, .glb, .vtp or .3mf file to write; with --parts a folder");
  Option isovalue = verb.add_option("--isovalue VALUE", options.isovalue,
                                    "Of grey values: what is at or above lies inside");
  add_label_option(verb, options.labels, "A label that lies inside").excludes(isovalue);
  add_level(verb, options.level);
  verb.add_parsed("--seed X,Y,Z", options.seed, parse_point,
                  "x,y,z in voxels of the level: only the piece of the surface there");
  Option deviation =
      verb.add_parsed("--max-deviation DISTANCE", options.max_deviation, parse_deviation,
                      "How far fewer triangles may lie from all: mm, or 0.5voxel; 0 keeps all")
          .default_str("0.5voxel");
  Option triangles =
      verb.add_parsed(
              "--triangles N|P%", options.triangles, parse_triangles,
              "So many at most: a number, or 5% of all; the deviation is proven and printed")
          .excludes(deviation);
  verb.add_word("--method METHOD", arguments.method,
                "How triangles become fewer: edges collapse, or cells merge\n"
                "(default: collapse); not with --parts or --interfaces")
      .excludes(triangles);
  verb.add_option("--report FILE", options.report_path,
                  "A file for what is known of the surface, as JSON");
  verb.add_word("--space SPACE", options.space, "Axes of the coordinates");
  verb.add_flag("--stored", options.is_stored, "The isovalue is a stored value, not a real one");
  verb.add_flag("--plain", options.is_plain,
                "A .glb file without compression and extensions, for programs that lack them");
  verb.add_flag("--allow-open", options.allows_faults,
                "Write a surface with faults as well, with exit code 0");
  add_label_surface_options(verb, arguments);
}

}  // namespace octavo::cli
