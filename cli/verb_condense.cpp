// octavo condense: the region octree of a grey volume, its cubes evened out to their means.
#include <memory>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/files/condense_volume.h"
#include "text/built_words.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCondenseText = {
    "condense", "Even out the cubes of a grey volume that hardly vary.",
    "The cubes of the octree, up to the whole volume, whose largest and smallest voxel differ by\n"
    "at most --flat take their mean; the largest such cubes count. float32 voxels must be\n"
    "multiples of one number, and a mean is the nearest of these. Of a cube at the border the\n"
    "voxels inside count, so slices and thin stacks condense too. No voxel changes by more. The\n"
    "result is an ordinary grey volume with large uniform cubes.\n\n"
    "Examples:\n"
    "  octavo condense head.8vo --flat 20 -o cubes.8vo\n"
    "  octavo render cubes.8vo --mode transparency -o cubes.png"};

struct CondenseArguments {
  std::string input;
  std::string output;
  std::string flat;
};

int run_condense(const CondenseArguments& arguments, Context& context) {
  const double flat = parse_number(arguments.flat, "--flat");
  if (flat < 0) {
    throw Error(ErrorKind::invalid_argument, "--flat " + arguments.flat + ": must not be negative");
  }
  const CondenseVolumeOptions options = {arguments.input, {arguments.output, context.force}, flat};
  print_built(run_task(condense_volume, options, context), arguments.output, context);
  return kExitDone;
}

}  // namespace

void add_condense(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<CondenseArguments>();
  Verb verb = add_verb(app, context, kCondenseText,
                            [arguments, &context] { return run_condense(*arguments, context); });
  verb.add_input(arguments->input);
  verb.add_output(arguments->output, "The .8vo file to write");
  verb.add_option("--flat", arguments->flat,
                  "The most by which the voxels of a cube may differ, real units")
      ->type_name("T")
      ->required();
}

}  // namespace octavo::cli
