// octavo dilate, erode, open, close: masks grown and shrunk.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/morph.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
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

struct MorphArguments {
  std::string input;
  std::string output;
  std::optional<std::string> mm;
  std::optional<std::string> voxels;
  std::optional<int> connectivity;
};

void require_length(bool is_length, const char* option, const std::string& text) {
  if (is_length) return;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{}: '{}'; must be 0 or more", option, escaped(text)));
}

MorphOptions options_of(Morphology morphology, const MorphArguments& arguments,
                        const Context& context) {
  MorphOptions options;
  options.morphology = morphology;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  options.connectivity = static_cast<Connectivity>(arguments.connectivity.value_or(6));
  if (!arguments.mm) {
    options.steps = parse_integer(*arguments.voxels, "--voxels");
    require_length(options.steps >= 0, "--voxels", *arguments.voxels);
    return options;
  }
  if (arguments.connectivity) {
    throw Error(ErrorKind::invalid_argument,
                "--connectivity says how --voxels counts; with --mm it says nothing");
  }
  options.mm = parse_number(*arguments.mm, "--mm");
  require_length(*options.mm >= 0, "--mm", *arguments.mm);
  return options;
}

int run_morph(Morphology morphology, const MorphArguments& arguments, Context& context) {
  const MorphOptions options = options_of(morphology, arguments, context);
  const MorphResult result = run_task(morph, options, context);
  print_result(context,
               {{"output", arguments.output},
                {"operation", morphology_name(morphology)},
                {"voxels", result.voxels},
                {"mm3", optional_json(mm3_of(result.voxels, result.volume))},
                {"voxels_before", result.voxels_before},
                {"file_bytes", result.file_bytes}},
               fmt::format("{}: {} (before: {})\n", escaped(arguments.output),
                           volume_text(result.voxels, result.volume),
                           volume_text(result.voxels_before, result.volume)));
  return kExitDone;
}

void add_morph(CLI::App& app, Context& context, const VerbText& text, Morphology morphology) {
  const auto arguments = std::make_shared<MorphArguments>();
  Verb verb = add_verb(app, context, text, [arguments, morphology, &context] {
    return run_morph(morphology, *arguments, context);
  });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_output(arguments->output, "The .8vo mask to write");
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

void add_dilate(CLI::App& app, Context& context) {
  add_morph(app, context, kDilateText, Morphology::dilate);
}
void add_erode(CLI::App& app, Context& context) {
  add_morph(app, context, kErodeText, Morphology::erode);
}
void add_open(CLI::App& app, Context& context) {
  add_morph(app, context, kOpenText, Morphology::open);
}
void add_close(CLI::App& app, Context& context) {
  add_morph(app, context, kCloseText, Morphology::close);
}

}  // namespace octavo::cli
