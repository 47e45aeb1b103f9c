// octavo condense: the region octree of a grey volume, its cubes evened out to their means; or how
// many of its cubes look like another one.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/files/condense_volume.h"
#include "octavo/tasks/structure/self_similarity.h"
#include "text/built_words.h"
#include "text/fact_json.h"
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
    "--self-similar T writes nothing: it counts the cubes of side 16, 8 and 4 that equal another\n"
    "one of their level, or of the next coarser one halved, turned or mirrored, within T at every\n"
    "voxel. What references would save is the share of the codec's bytes that these cubes have,\n"
    "less the bits of the references. With --up-to-mean only what differs from each cube's mean\n"
    "counts. --coded names the file whose bytes are saved, as one built with --max-error T.\n\n"
    "Examples:\n"
    "  octavo condense head.8vo --flat 20 -o cubes.8vo\n"
    "  octavo render cubes.8vo --mode transparency -o cubes.png\n"
    "  octavo condense head.8vo --self-similar 0"};

struct CondenseArguments {
  std::string input;
  std::optional<Output> output;
  std::optional<double> flat;
  std::optional<double> similar;
  std::string coded;
  bool is_up_to_mean = false;
};

double parse_flat(const std::string& text, const std::string& option) {
  const double flat = parse_number(text, option);
  if (flat >= 0) return flat;
  throw Error(ErrorKind::invalid_argument, option + " " + text + ": must not be negative");
}

nlohmann::ordered_json similarity_json(const std::string& input,
                                       const SelfSimilarityOptions& options,
                                       const SelfSimilarityResult& result) {
  return {{"input", public_name(input)},
          {"max_difference", options.max_difference},
          {"up_to_mean", options.is_up_to_mean},
          {"file_bytes", result.file_bytes},
          {"levels", json_of(list_of_facts(result.levels, similarity_facts))},
          {"saved_bytes", result.saved_bytes()}};
}

std::string similarity_text(const SelfSimilarityResult& result) {
  std::string text;
  for (const SimilarityLevel& level : result.levels) {
    text += fmt::format("cubes of side {}: {} of {} asked; {} equal another of their level, {} of "
                        "the next; {} turned\n",
                        level.side, level.asked, level.cubes, level.same_level, level.next_level,
                        level.turned);
    if (level.same_level + level.next_level > 0) {
      text += fmt::format("  {:.0f} bytes of the codec, {:.0f} of references: {}\n",
                          level.coded_bytes, level.reference_bytes,
                          level.saved_bytes() > 0 ? "saved" : "not worth it");
    }
    if (level.cut_short > 0) {
      text += fmt::format("  {} given up after too many candidates\n", level.cut_short);
    }
  }
  const double share =
      100 * result.saved_bytes() / static_cast<double>(result.file_bytes);
  return text + fmt::format("references would save {:.0f} of {} bytes ({:.2f} %)\n",
                            result.saved_bytes(), result.file_bytes, share);
}

int run_similarity(const CondenseArguments& arguments, Context& context) {
  const SelfSimilarityOptions options = {arguments.input, *arguments.similar,
                                         arguments.is_up_to_mean, arguments.coded};
  const SelfSimilarityResult result = run_task(self_similarity, options, context);
  print_result(context, similarity_json(arguments.input, options, result),
               similarity_text(result));
  return kExitDone;
}

int run_condense(const CondenseArguments& arguments, Context& context) {
  if (arguments.similar) return run_similarity(arguments, context);
  if (!arguments.flat || !arguments.output) {
    throw Error(ErrorKind::invalid_argument,
                "give --flat and -o for a condensed volume, or --self-similar");
  }
  if (arguments.is_up_to_mean || !arguments.coded.empty()) {
    throw Error(ErrorKind::invalid_argument, "--up-to-mean and --coded need --self-similar");
  }
  const CondenseVolumeOptions options = {arguments.input, *arguments.output, *arguments.flat};
  print_built(run_task(condense_volume, options, context), arguments.output->path, context);
  return kExitDone;
}

}  // namespace

void add_condense(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kCondenseText, run_condense);
  verb.add_input(arguments.input);
  const Option output =
      verb.add_output_option("-o,--output FILE", arguments.output, "The .8vo file to write");
  const Option flat =
      verb.add_parsed("--flat T", arguments.flat, parse_flat,
                      "The most by which the voxels of a cube may differ, real units");
  verb.add_parsed("--self-similar T", arguments.similar, parse_number,
                  "Count cubes that equal another one within T at every voxel, real units")
      .excludes(flat)
      .excludes(output);
  verb.add_flag("--up-to-mean", arguments.is_up_to_mean,
                "With --self-similar: compare what differs from each cube's mean");
  verb.add_option("--coded FILE", arguments.coded,
                  "With --self-similar: the file whose bytes references would save");
}

}  // namespace octavo::cli
