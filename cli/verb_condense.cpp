// octavo condense: the region octree of a grey volume, its cubes evened out to their means.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/building.h"
#include "common/failure.h"
#include "common/inputs.h"
#include "common/options.h"
#include "octavo/builder/flat_cubes.h"
#include "octavo/builder/metadata_member.h"
#include "octavo/tasks/file_planes.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "condense", "Even out the cubes of a grey volume that hardly vary.",
    "The cubes of the octree, up to the whole volume, whose greatest and least voxel differ by at\n"
    "most --flat take their mean; the largest such cubes count. No voxel changes by more. The\n"
    "result is an ordinary grey volume with large uniform cubes.\n\n"
    "Examples:\n"
    "  octavo condense head.8vo --flat 20 -o cubes.8vo\n"
    "  octavo render cubes.8vo --mode transparency -o cubes.png"};

struct Arguments {
  std::string input;
  std::string output;
  std::string flat_text;
  double flat = 0;
};

/// The asked flatness in whole stored units.
std::int64_t stored_flat(double flat, const Rescale& rescale) {
  constexpr double kMost = 4.6e18;
  constexpr double kRounding = 1e-9;  // of a quotient that should be whole
  const double slope = rescale.slope == 0 ? 1 : std::abs(rescale.slope);
  return static_cast<std::int64_t>(std::min(kMost, std::floor(flat / slope * (1 + kRounding))));
}

int run_condense(Arguments& arguments, Context& context) {
  arguments.flat = parse_number(arguments.flat_text, "--flat");
  if (arguments.flat < 0) {
    throw Error(ErrorKind::invalid_argument,
                "--flat " + arguments.flat_text + ": must not be negative");
  }
  require_computed_output(arguments.output, {arguments.input}, context);
  const std::shared_ptr<const FileReader> reader = open_octavo(arguments.input, context);
  const VolumeDescription& volume = reader->description();
  if (volume.kind == VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument,
                "holds labels, which are condensed as they are; only grey volumes have means",
                arguments.input);
  }
  if (!is_integer(volume.type)) {
    throw Error(ErrorKind::invalid_argument,
                "holds float32 voxels; only volumes of whole numbers are condensed",
                arguments.input);
  }
  VolumeDescription description =
      FilePlanes(reader, 0, context.thread_count()).description();
  const nlohmann::ordered_json made_by = {{"operation", "condense"}, {"flat", arguments.flat}};
  description.metadata_json = with_member(description.metadata_json, "made_by", made_by.dump());
  const auto source = make_flat_cubes(
      reader, description, stored_flat(arguments.flat, volume.rescale), context.thread_count());
  return build_and_report(*source, {.is_resumable = false}, arguments.output, context);
}

}  // namespace

void add_condense(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_condense(*arguments, context); });
  verb.add_option("file", arguments->input, "An .8vo file or a URL of one")
      ->type_name("FILE")
      ->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo file to write")
      ->type_name("FILE")
      ->required();
  verb.add_option("--flat", arguments->flat_text,
                  "The most by which the voxels of a cube may differ, real units")
      ->type_name("T")
      ->required();
}

}  // namespace octavo::cli
