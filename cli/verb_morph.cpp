// octavo dilate, erode, open, close: masks grown and shrunk.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "common/progress_line.h"
#include "octavo/ops/mask/morphology.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kDilateText = {
    "dilate", "Grow a mask by a distance in mm, or by steps from voxel to neighbor.",
    "With --mm R, a voxel is in the result when the center of some voxel of the mask lies within\n"
    "R mm of its own: a true ball, whatever the spacing. With --voxels N, when N steps to a\n"
    "neighbor lead there; neighbors share a face, or with --connectivity 18 or 26 an edge or a\n"
    "corner as well. Time grows with the surface of the mask and about with the square of the\n"
    "distance in voxels.\n\n"
    "Examples:\n"
    "  octavo dilate tumor.8vo --mm 10 -o margin.8vo\n"
    "  octavo dilate vessels.8vo --voxels 1 --connectivity 26 -o thicker.8vo"};

constexpr VerbText kErodeText = {
    "erode", "Shrink a mask by a distance in mm, or by steps from voxel to neighbor.",
    "A voxel stays when no voxel of the background lies within the distance; see 'octavo dilate\n"
    "--help' for distances. What lies outside the volume does not erode: where an object is cut\n"
    "off by the border of the volume it keeps that border.\n\n"
    "Examples:\n"
    "  octavo erode skin.8vo --mm 3 -o inside.8vo\n"
    "  octavo erode mask.8vo --voxels 1 -o core.8vo"};

constexpr VerbText kOpenText = {
    "open", "Remove what is thinner than a ball from a mask: erode, then dilate.",
    "What is left are the places that the ball fits into: bridges, spikes and grains that are\n"
    "thinner than about twice the distance are gone, all else stays as it is. Distances are\n"
    "those of 'octavo dilate --help'; at the border of the volume nothing is lost.\n\n"
    "Examples:\n"
    "  octavo open bone.8vo --mm 1.5 -o without-bridges.8vo"};

constexpr VerbText kCloseText = {
    "close", "Close gaps of a mask that a ball does not fit into: dilate, then erode.",
    "Cracks, pits and pores narrower than about twice the distance become part of the mask, all\n"
    "else stays as it is. Distances are those of 'octavo dilate --help'. Holes of any size are\n"
    "filled by 'octavo fill-holes'.\n\n"
    "Examples:\n"
    "  octavo close skull.8vo --mm 4 -o sealed.8vo"};

using Operation = MaskTree (*)(const MaskTree&, const Reach&, Progress&, std::uint64_t);

struct Arguments {
  std::string input;
  std::string output;
  std::optional<std::string> mm;
  std::optional<std::string> voxels;
  std::optional<int> connectivity;

  Connectivity neighbors() const { return static_cast<Connectivity>(connectivity.value_or(6)); }
};

struct Distance {
  std::optional<double> mm;
  std::int64_t steps = 0;  ///< where mm were not asked for
};

Distance asked_distance(const Arguments& arguments) {
  const auto require_length = [](bool is_length, const char* option, const std::string& text) {
    if (is_length) return;
    throw Error(ErrorKind::invalid_argument,
                fmt::format("{}: '{}'; must be 0 or more", option, escaped(text)));
  };
  Distance distance;
  if (!arguments.mm) {
    distance.steps = parse_integer(*arguments.voxels, "--voxels");
    require_length(distance.steps >= 0, "--voxels", *arguments.voxels);
    return distance;
  }
  if (arguments.connectivity) {
    throw Error(ErrorKind::invalid_argument,
                "--connectivity says how --voxels counts; with --mm it says nothing");
  }
  distance.mm = parse_number(*arguments.mm, "--mm");
  require_length(*distance.mm >= 0, "--mm", *arguments.mm);
  return distance;
}

Reach reach_of(const Distance& distance, const Arguments& arguments,
               const VolumeDescription& volume, std::uint64_t max_bytes) {
  if (!distance.mm) {
    return Reach::in_steps(distance.steps, arguments.neighbors(), volume.size, max_bytes);
  }
  require_known_spacing(volume, arguments.input, "--mm", "--voxels");
  return Reach::within_mm(*distance.mm, volume.geometry.spacing_mm, volume.size, max_bytes);
}

nlohmann::ordered_json made_by_json(const char* name, const Distance& distance,
                                    const Arguments& arguments) {
  nlohmann::ordered_json made_by = {{"operation", name}};
  if (distance.mm) {
    made_by["mm"] = *distance.mm;
  } else {
    made_by["steps"] = distance.steps;
    made_by["connectivity"] = static_cast<int>(arguments.neighbors());
  }
  return made_by;
}

int run_morph(const char* name, Operation operation, const Arguments& arguments,
              Context& context) {
  const Distance distance = asked_distance(arguments);
  require_computed_output(arguments.output, {arguments.input}, context);
  const OpenedMask mask = open_mask(arguments.input, context);
  const VolumeDescription& volume = mask.volume();
  const Reach reach = reach_of(distance, arguments, volume, context.max_memory_bytes);
  // The mask, its surface, what it grows to in pieces and whole; the ball; a window per thread.
  require_memory(5 * mask.tree.memory_bytes() + reach.memory_bytes() +
                     dilation_thread_bytes(reach, volume.size) *
                         static_cast<std::uint64_t>(context.thread_count()),
                 "masks that grow", context);
  MaskTree made;
  {
    ProgressLine progress(context);
    on_threads(context, [&] {
      made = operation(mask.tree, reach, progress, context.max_memory_bytes);
    });
  }
  const std::uint64_t before = mask.tree.voxel_count();
  const std::uint64_t voxels = made.voxel_count();
  if (voxels == 0 && before > 0) {
    context.warn(arguments.output + ": is empty; no voxel of " + arguments.input + " is left");
  }
  const BuildResult built = write_mask(made, volume, made_by_json(name, distance, arguments),
                                       arguments.output, context);
  if (context.json) {
    print_json({{"output", arguments.output},
                {"operation", name},
                {"voxels", voxels},
                {"mm3", mm3_json(voxels, volume)},
                {"voxels_before", before},
                {"file_bytes", built.file_bytes},
                {"warnings", context.warnings}});
  } else if (!context.quiet) {
    print(fmt::format("{}: {} (before: {})\n", escaped(arguments.output),
                      volume_text(voxels, volume), volume_text(before, volume)));
  }
  return kExitDone;
}

void add_morph(CLI::App& app, Context& context, const VerbText& text, Operation operation) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, text,
                            [arguments, operation, name = text.name, &context] {
                              return run_morph(name, operation, *arguments, context);
                            });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")
      ->type_name("FILE")
      ->required();
  Verb distance = verb.add_choice("Distance");
  distance.add_option("--mm", arguments->mm, "Radius of the ball, mm, between voxel centers")
      ->type_name("R");
  distance.add_option("--voxels", arguments->voxels, "Steps from voxel to neighbor")
      ->type_name("N");
  verb.add_option("--connectivity", arguments->connectivity,
                  "Neighbors share a face (6, the default), an edge (18) or a corner (26) as well")
      ->type_name("C")
      ->check(one_of({6, 18, 26}));
}

}  // namespace

void add_dilate(CLI::App& app, Context& context) { add_morph(app, context, kDilateText, dilate); }
void add_erode(CLI::App& app, Context& context) { add_morph(app, context, kErodeText, erode); }
void add_open(CLI::App& app, Context& context) { add_morph(app, context, kOpenText, opening); }
void add_close(CLI::App& app, Context& context) { add_morph(app, context, kCloseText, closing); }

}  // namespace octavo::cli
