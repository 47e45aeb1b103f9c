// octavo fill-holes: background that is enclosed by an object becomes part of it.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "octavo/ops/mask/fill_holes.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "fill-holes", "Fill the holes of a mask.",
    "A hole is a part of the background that does not reach the border of the volume.\n"
    "--connectivity is that of the object; the background is connected the other way: with 26\n"
    "(the default) or 18 the background is joined by faces alone, so that a wall closed up to its\n"
    "edges holds it, as in scipy and fslmaths; with 6 it passes through edges and corners as\n"
    "well, so that fewer holes are found.\n\n"
    "Examples:\n"
    "  octavo fill-holes skull.8vo -o solid.8vo\n"
    "  octavo fill-holes bone.8vo --max-mm3 5 -o bone-closed.8vo\n"
    "  octavo fill-holes shell.8vo --connectivity 6 -o filled.8vo --json"};

struct Arguments {
  std::string input;
  std::string output;
  int connectivity = 26;
  std::optional<double> max_mm3;
};

/// The largest hole that is filled, in voxels.
std::uint64_t max_voxels(const Arguments& arguments, const VolumeDescription& volume) {
  if (!arguments.max_mm3) return std::numeric_limits<std::uint64_t>::max();
  require_known_spacing(volume, arguments.input, "--max-mm3");
  const auto mm3 = voxel_mm3(volume);
  // A volume of whole voxels is not lost to a rounded quotient.
  constexpr double kRoundingSlack = 1e-9;
  const double voxels = *arguments.max_mm3 / *mm3 * (1 + kRoundingSlack);
  return static_cast<std::uint64_t>(std::min(std::floor(voxels), 1e18));
}

std::string holes_text(const FilledHoles& filled, const VolumeDescription& volume) {
  const std::string left =
      filled.kept_count == 0
          ? ""
          : fmt::format("; {} larger left",
                        count_text(static_cast<std::int64_t>(filled.kept_count)));
  if (filled.hole_count == 0) return "no holes filled" + left;
  return fmt::format("{} filled ({}){}",
                     counted_text(static_cast<std::int64_t>(filled.hole_count), "hole"),
                     volume_text(filled.voxel_count, volume), left);
}

int run_fill_holes(const Arguments& arguments, Context& context) {
  require_computed_output(arguments.output, {arguments.input}, context);
  const OpenedMask mask = open_mask(arguments.input, context);
  const VolumeDescription& volume = mask.volume();
  const std::uint64_t largest = max_voxels(arguments, volume);
  // The complement, its components, those selected and the result.
  require_memory(6 * mask.tree.memory_bytes(), "the holes", context);
  FilledHoles filled;
  on_threads(context, [&] {
    filled = fill_holes(mask.tree, static_cast<Connectivity>(arguments.connectivity), largest,
                        context.max_memory_bytes);
  });
  nlohmann::ordered_json made_by = {{"operation", "fill-holes"},
                                    {"connectivity", arguments.connectivity}};
  if (arguments.max_mm3) made_by["max_mm3"] = *arguments.max_mm3;
  const BuildResult built = write_mask(filled.mask, volume, made_by, arguments.output, context);
  const std::uint64_t voxels = filled.mask.voxel_count();
  if (context.json) {
    print_json({{"output", arguments.output},
                {"operation", "fill-holes"},
                {"voxels", voxels},
                {"mm3", mm3_json(voxels, volume)},
                {"holes", filled.hole_count},
                {"hole_voxels", filled.voxel_count},
                {"hole_mm3", mm3_json(filled.voxel_count, volume)},
                {"larger_holes", filled.kept_count},
                {"file_bytes", built.file_bytes},
                {"warnings", context.warnings}});
  } else if (!context.quiet) {
    print(fmt::format("{}: {}; {}\n", escaped(arguments.output), volume_text(voxels, volume),
                      holes_text(filled, volume)));
  }
  return kExitDone;
}

}  // namespace

void add_fill_holes(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_fill_holes(*arguments, context); });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")
      ->type_name("FILE")
      ->required();
  verb.add_option("--connectivity", arguments->connectivity,
                  "The object is joined by faces (6), edges (18) or corners (26)")
      ->type_name("N")
      ->check(one_of({6, 18, 26}))
      ->capture_default_str();
  verb.add_option("--max-mm3", arguments->max_mm3, "Fill only holes of this volume or less")
      ->type_name("V")
      ->check(not_negative());
}

}  // namespace octavo::cli
