// octavo dilate, erode, open, close: masks grown and shrunk.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/morph.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"
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
  MorphOptions options;
  std::optional<Connectivity> connectivity;
};

template <class Number>
Number not_below_zero(Number number, const std::string& text, const std::string& option) {
  if (number >= 0) return number;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{}: '{}'; must be 0 or more", option, escaped(text)));
}

std::int64_t parse_steps(const std::string& text, const std::string& option) {
  return not_below_zero(parse_integer(text, option), text, option);
}

double parse_radius(const std::string& text, const std::string& option) {
  return not_below_zero(parse_number(text, option), text, option);
}

int run_morph(const MorphArguments& arguments, Context& context) {
  MorphOptions options = arguments.options;
  if (arguments.connectivity && options.mm) {
    throw Error(ErrorKind::invalid_argument,
                "--connectivity says how --voxels counts; with --mm it says nothing");
  }
  options.connectivity = arguments.connectivity.value_or(Connectivity::faces);
  const MorphResult result = run_task(morph, options, context);
  print_result(context,
               {{"output", options.output.path},
                {"operation", word_of(options.morphology)},
                {"voxels", result.voxels},
                {"mm3", json_of(mm3_of(result.voxels, result.volume))},
                {"voxels_before", result.voxels_before},
                {"file_bytes", result.file_bytes}},
               fmt::format("{}: {} (before: {})\n", shown_path(options.output.path),
                           volume_text(result.voxels, result.volume),
                           volume_text(result.voxels_before, result.volume)));
  return kExitDone;
}

void add_morph(CLI::App& app, Context& context, const VerbText& text, Morphology morphology) {
  auto [verb, arguments] = add_verb(app, context, text, run_morph);
  MorphOptions& options = arguments.options;
  options.morphology = morphology;
  add_mask_input(verb, options.input);
  verb.add_output(options.output, "The .8vo mask to write");
  Verb distance = verb.add_choice("Distance");
  distance.add_parsed("--mm R", options.mm, parse_radius,
                      "Radius of the ball, mm, between voxel centers");
  distance.add_parsed("--voxels N", options.steps, parse_steps, "Steps from voxel to neighbor");
  add_connectivity(
      verb, arguments.connectivity,
      "Neighbors share a face (6, the default), an edge (18) or a corner (26) as well");
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
