// octavo hexahedra: a mesh of cubes for solvers.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/hexahedra.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/volume_json.h"
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
  HexahedraOptions options;
  double min_modulus = 1;
};

DensityLine parse_density(const std::string& text, const std::string& option) {
  const std::vector<double> numbers = parse_numbers(text, option, 2, "two numbers, A,B");
  return {numbers[0], numbers[1]};
}

ModulusPower parse_modulus(const std::string& text, const std::string& option) {
  const std::vector<double> numbers = parse_numbers(text, option, 2, "two numbers, A,B");
  return {numbers[0], numbers[1], 0};
}

std::string hexahedra_text(const HexahedraOptions& options, const HexahedraResult& result) {
  const auto& [cubes, pyramids, tetrahedra] = result.elements_of_shape;
  std::string text = fmt::format(
      "{}: {} of {}, {}", shown_path(options.output.path),
      count_of(result.element_count, "element"), count_of(result.voxel_count, "voxel"),
      count_of(result.node_count, "node"));
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

nlohmann::ordered_json hexahedra_json(const HexahedraOptions& options,
                                      const HexahedraResult& result) {
  return {{"output", options.output.path},
          {"file_bytes", result.file_bytes},
          {"level", options.level},
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
          {"modulus_range_mpa", json_of(result.modulus_range_mpa)},
          {"volume_mm3", if_in_mm(result.volume, result.volume_mm3)},
          {"quality", json_of(facts_if(result.quality, quality_facts))}};
}

int run_hexahedra(const HexahedraArguments& arguments, Context& context) {
  HexahedraOptions options = arguments.options;
  if (options.modulus) options.modulus->minimum_mpa = arguments.min_modulus;
  const HexahedraResult result = run_task(hexahedra, options, context);
  print_result(context, hexahedra_json(options, result), hexahedra_text(options, result));
  return kExitDone;
}

void add_materials(Verb verb, HexahedraArguments& arguments) {
  HexahedraOptions& options = arguments.options;
  verb.add_option("--of GREY", options.grey, "The grey volume that the elements take values from");
  verb.add_parsed("--density SLOPE,INTERCEPT", options.density, parse_density,
                  "g/cm3 of a grey value: SLOPE * value + INTERCEPT; needs --of, and --modulus "
                  "but for .vtu");
  verb.add_parsed("--modulus A,B", options.modulus, parse_modulus,
                  "MPa of a density: A * density^B; needs --density");
  verb.add_option("--min-modulus MPA", arguments.min_modulus, "MPa that no element is below")
      .check(above_zero())
      .capture_default_str();
  verb.add_option("--poisson NU", options.poisson_ratio, "Poisson's ratio of the materials")
      .capture_default_str();
  verb.add_option("--bins N", options.bin_count, "Materials that each label has at most")
      .check(whole_within(1, 100000))
      .capture_default_str();
}

}  // namespace

void add_hexahedra(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kHexahedraText, run_hexahedra);
  HexahedraOptions& options = arguments.options;
  verb.add_input(options.input);
  verb.add_output(options.output, "The .vtu, .inp, .msh or .mesh file to write");
  Option uniform = verb.add_flag_of("--uniform", options.method, HexMethod::uniform,
                                    "Every voxel an element; the default");
  Option octree = verb.add_flag_of("--octree", options.method, HexMethod::octree,
                                   "Leaves of the octree; nodes hang, but not in .msh")
                      .excludes(uniform);
  verb.add_flag_of("--conforming", options.method, HexMethod::conforming,
                   "Leaves of the octree, with pyramids and tetrahedra between their sizes")
      .excludes(uniform)
      .excludes(octree);
  add_level(verb, options.level);
  add_label_option(verb, options.labels, "A label whose voxels become elements");
  verb.add_flag("--keep-largest", options.keep_largest,
                "Only the largest part that is connected over faces");
  add_materials(verb, arguments);
  verb.add_flag("--quality", options.has_quality,
                "Scaled Jacobians and volumes of the elements as well");
}

}  // namespace octavo::cli
