// octavo hexahedra: a mesh of cubes for solvers.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/label_option.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/hexahedra.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kHexahedraText = {
    "hexahedra", "Make a mesh of hexahedra for solvers: VTU, Abaqus, Gmsh or MFEM.",
    "Of a mask or a label map every voxel of a level as an element (--uniform), or the leaves of\n"
    "its octree, so elements are large inside. Leaves that touch differ by one level at most,\n"
    "also at edges and corners. With --octree nodes hang in the middle of edges and faces of\n"
    "larger elements, and the file says what they are the mean of: *EQUATION in .inp,\n"
    "vertex_parents in .mesh, the array masters in .vtu. A .mesh with --octree has more elements\n"
    "than the others: leaves are halved where a single smaller one lies on a face, which MFEM\n"
    "cannot express. With --conforming no node hangs: leaves beside smaller ones fall into\n"
    "pyramids and tetrahedra around their center, which may be more elements than there are\n"
    "voxels. The volume is that of the voxels.\n\n"
    "Coordinates are mm in LPS. Each label is a set of elements, LABEL_3, or LABEL_3_left_kidney\n"
    "where it has a name; comments, in .vtu field data, have names and colors as they are. The\n"
    "six sides of the box around the mesh, along the axes of the grid, are the sets X_MIN to\n"
    "Z_MAX of nodes that do not hang (.inp) and the boundary attributes 1 to 6 (.mesh). Reaction\n"
    "forces added up over such a set lack those of nodes that hang in the side: use --uniform or\n"
    "--conforming for totals. Pyramids in .inp are C3D8 with four nodes in one. The\n"
    "attribute of an element in .mesh is its label; with materials, or where a label is below 1\n"
    "or above 2147483647, attributes are counted from 1. Comments at the beginning say the\n"
    "label of each.\n\n"
    "--of gives each element the mean of the grey values in it; --density turns that into a\n"
    "density in g/cm3, SLOPE * value + INTERCEPT, as your calibration says; --modulus turns that\n"
    "into a modulus in MPa, A * density^B, where densities below 0 are taken as 0 and a warning\n"
    "counts them; the densities in .vtu stay as they are. Materials are bins of the modulus,\n"
    "equally wide over all labels; each label has materials of its own, up to --bins of them.\n"
    "Without it an .inp has no material; only .vtu takes --density alone.\n\n"
    "Examples:\n"
    "  octavo hexahedra skull.8vo -o skull.vtu\n"
    "  octavo hexahedra skull.8vo --octree --keep-largest -o skull.inp\n"
    "  octavo hexahedra bone.8vo --of ct.8vo --density 0.001,0 --modulus 6850,1.49 -o bone.inp"};

struct HexahedraArguments {
  std::string input;
  std::string output;
  bool uniform = false;
  bool octree = false;
  bool conforming = false;
  std::vector<std::string> labels;
  int level = 0;
  bool keep_largest = false;
  std::string grey;
  std::string density;
  std::string modulus;
  double min_modulus = 1;
  double poisson = 0.3;
  int bins = 32;
  bool quality = false;
};

/// "A,B"
std::array<double, 2> parse_pair(const std::string& text, const char* what) {
  const std::vector<std::string> parts = split(text, ',');
  if (parts.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                std::string(what) + ": expected two numbers, A,B, found " + escaped(text));
  }
  return {parse_number(parts[0], what), parse_number(parts[1], what)};
}

HexahedraOptions options_of(const HexahedraArguments& arguments, const Context& context) {
  HexahedraOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  if (arguments.octree) options.method = HexMethod::octree;
  if (arguments.conforming) options.method = HexMethod::conforming;
  options.labels = parse_labels(arguments.labels);
  options.level = arguments.level;
  options.keep_largest = arguments.keep_largest;
  options.grey = arguments.grey;
  if (!arguments.density.empty()) {
    const auto [slope, intercept] = parse_pair(arguments.density, "--density");
    options.density = DensityLine{slope, intercept};
  }
  if (!arguments.modulus.empty()) {
    const auto [factor, exponent] = parse_pair(arguments.modulus, "--modulus");
    options.modulus = ModulusPower{factor, exponent, arguments.min_modulus};
  }
  options.poisson_ratio = arguments.poisson;
  options.bin_count = arguments.bins;
  options.has_quality = arguments.quality;
  return options;
}

std::string hexahedra_text(const HexahedraArguments& arguments, const HexahedraResult& result) {
  const auto& [cubes, pyramids, tetrahedra] = result.elements_of_shape;
  std::string text = fmt::format(
      "{}: {} of {}, {}", arguments.output, count_of(result.element_count, "element"),
      count_of(result.voxel_count, "voxel"), count_of(result.node_count, "node"));
  if (result.hanging_count != 0) {
    text += fmt::format(", {} of them hang", count_of(result.hanging_count));
  }
  text += "\n";
  if (pyramids + tetrahedra != 0) {
    text += fmt::format("{} hexahedra, {} pyramids, {} tetrahedra\n", count_of(cubes),
                        count_of(pyramids), count_of(tetrahedra));
  }
  if (result.modulus_range_mpa) {
    const auto& [lowest, highest] = *result.modulus_range_mpa;
    text += fmt::format("modulus {:.6g} to {:.6g} MPa, {} materials\n", lowest, highest,
                        result.material_count);
  }
  if (is_spacing_known(result.volume)) {
    text += fmt::format("volume {:.6g} mm3\n", result.volume_mm3);
  }
  if (result.quality) {
    const HexQuality& quality = *result.quality;
    text += fmt::format("scaled Jacobian {:.4g} at the lowest, {:.4g} of 5 %, {:.4g} of half\n",
                        quality.percentile(0), quality.percentile(5), quality.percentile(50));
    text += fmt::format("elements of {:.6g} to {:.6g} mm3\n", quality.min_volume_mm3,
                        quality.max_volume_mm3);
  }
  return text;
}

nlohmann::ordered_json quality_json(const HexahedraResult& result) {
  if (!result.quality) return nullptr;
  const HexQuality& quality = *result.quality;
  return {{"scaled_jacobian",
           {{"min", quality.percentile(0)},
            {"p1", quality.percentile(1)},
            {"p5", quality.percentile(5)},
            {"p50", quality.percentile(50)},
            {"max", quality.percentile(100)}}},
          {"min_volume_mm3", quality.min_volume_mm3},
          {"max_volume_mm3", quality.max_volume_mm3},
          {"total_volume_mm3", quality.total_volume_mm3}};
}

nlohmann::ordered_json hexahedra_json(const HexahedraArguments& arguments,
                                      const HexahedraResult& result, const Context& context) {
  nlohmann::ordered_json range = nullptr;
  if (result.modulus_range_mpa) range = *result.modulus_range_mpa;
  nlohmann::ordered_json volume = nullptr;
  if (is_spacing_known(result.volume)) volume = result.volume_mm3;
  return {{"output", arguments.output},
          {"file_bytes", result.file_bytes},
          {"level", arguments.level},
          {"elements", result.element_count},
          {"hexahedra", result.elements_of_shape[0]},
          {"pyramids", result.elements_of_shape[1]},
          {"tetrahedra", result.elements_of_shape[2]},
          {"cells", result.cell_count},
          {"cells_of_level", result.cells_of_level},
          {"voxels", result.voxel_count},
          {"nodes", result.node_count},
          {"hanging_nodes", result.hanging_count},
          {"parts", result.part_count},
          {"labels", result.labels},
          {"materials", result.material_count},
          {"modulus_range_mpa", range},
          {"volume_mm3", volume},
          {"quality", quality_json(result)},
          {"warnings", context.warnings}};
}

int run_hexahedra(const HexahedraArguments& arguments, Context& context) {
  const HexahedraResult result = run_task(hexahedra, options_of(arguments, context), context);
  if (context.json) print_json(hexahedra_json(arguments, result, context));
  else if (!context.quiet) print(hexahedra_text(arguments, result));
  return kExitDone;
}

void add_materials(Verb verb, HexahedraArguments& arguments) {
  verb.add_option("--of", arguments.grey, "The grey volume that the elements take values from")
      ->type_name("GREY");
  verb.add_option("--density", arguments.density,
                  "g/cm3 of a grey value: SLOPE * value + INTERCEPT; needs --of, and --modulus "
                  "but for .vtu")
      ->type_name("SLOPE,INTERCEPT");
  verb.add_option("--modulus", arguments.modulus,
                  "MPa of a density: A * density^B; needs --density")
      ->type_name("A,B");
  verb.add_option("--min-modulus", arguments.min_modulus, "MPa that no element is below")
      ->type_name("MPA")
      ->check(above_zero())
      ->capture_default_str();
  verb.add_option("--poisson", arguments.poisson, "Poisson's ratio of the materials")
      ->type_name("NU")
      ->capture_default_str();
  verb.add_option("--bins", arguments.bins, "Materials that each label has at most")
      ->type_name("N")
      ->check(whole_within(1, 100000))
      ->capture_default_str();
}

}  // namespace

void add_hexahedra(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<HexahedraArguments>();
  Verb verb = add_verb(app, context, kHexahedraText,
                       [arguments, &context] { return run_hexahedra(*arguments, context); });
  verb.add_input(arguments->input);
  verb.add_output(arguments->output, "The .vtu, .inp, .msh or .mesh file to write");
  Option uniform = verb.add_flag("--uniform", arguments->uniform,
                                 "Every voxel an element; the default");
  Option octree = verb.add_flag("--octree", arguments->octree,
                                "Leaves of the octree; nodes hang, but not in .msh");
  octree->excludes(uniform);
  verb.add_flag("--conforming", arguments->conforming,
                "Leaves of the octree, with pyramids and tetrahedra between their sizes")
      ->excludes(uniform)
      ->excludes(octree);
  verb.add_option("--level", arguments->level, "0 is the scan, coarser levels have fewer voxels")
      ->type_name("N")
      ->capture_default_str();
  add_label_option(verb, arguments->labels, "A label whose voxels become elements");
  verb.add_flag("--keep-largest", arguments->keep_largest,
                "Only the largest part that is connected over faces");
  add_materials(verb, *arguments);
  verb.add_flag("--quality", arguments->quality,
                "Scaled Jacobians and volumes of the elements as well");
}

}  // namespace octavo::cli
