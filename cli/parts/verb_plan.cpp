// octavo plan: what has to be known before a scan is built in parts.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "common/build_options.h"
#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/text.h"
#include "octavo/tasks/parts/plan_scan.h"
#include "parts/planned_work.h"
#include "text/quantities.h"
#include "text/shell_words.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kPlanText = {
    "plan", "Plan a build in parts, for many machines.",
    "Reads and trains on the first group of slices, and writes what every part has to know. Parts\n"
    "are then made by octavo part, in any order, on any number of machines, and octavo join makes\n"
    "the file of them: byte for byte the one of octavo build with the same options.\n\n"
    "The plan keeps the length and the time of every file of the source. A part is rejected where\n"
    "one of its files was changed since. Copies that did not keep their times are taken with\n"
    "--check content: the plan reads all files once, a part its own ones once more, and their\n"
    "bytes tell. That is for slices in files of their own.\n\n"
    "Where --max-memory holds no group, parts are made in bands of bricks, as by octavo build:\n"
    "give octavo part the same limit. The bytes are those without it.\n\n"
    "A part has whole groups of slices. --parts says how many parts there are, at most as many as\n"
    "groups; --part-size how many bytes of voxels a part holds at most, 4G unless told otherwise.\n"
    "\n"
    "--bands N goes below that, for scans so wide that groups are few and large: N parts share\n"
    "each group, and each encodes a band of its bricks. Every one of them reads the slices of its\n"
    "group once or twice, so let N be what machines or memory need, no more. Lossless volumes\n"
    "have it whose groups are one layer of bricks (64 slices of 32 MiB and more together), and\n"
    "which can be read from any slice on; others are rejected.\n\n"
    "A source that is compressed as one stream (.nii.gz) is read from its start by every part:\n"
    "the plan says so and proposes 8 parts at most.\n\n"
    "Paths below the folder of the plan stand relative to it, others absolute, so that a job may\n"
    "run in any folder. --source-root DIR makes paths relative to DIR instead; part\n"
    "--source-root takes the same files from another place.\n\n"
    "octavo plan -o work.plan -- VERB ... plans the volume that threshold, condense, transform,\n"
    "combine or components --numbers computes of .8vo files: the words are those of the verb\n"
    "without its -o. Two cases are not computed voxel by voxel and need no parts: a translation,\n"
    "which copies bricks, and combine --resample, which works on octrees. A matrix of --affine is\n"
    "read again by each part: give its absolute path.\n\n"
    "Examples:\n"
    "  octavo plan slices/ --spacing 0.0195 -o scan.plan\n"
    "  octavo plan slices/ --spacing 0.0195 --part-size 8G -o scan.plan\n"
    "  octavo plan scans/head/ --max-error 2 --parts 16 -o head.plan\n"
    "  octavo plan wide/ --spacing 0.005 --bands 8 --max-memory 4G -o wide.plan\n"
    "  octavo plan --parts 64 -o turned.plan -- transform bone.8vo --rotate z:30"};

struct PlanArguments {
  PlanScanOptions options;
  std::function<bool()> is_scan_told;  ///< by a source, or options of a build
};

/// A source, or a verb behind two dashes.
void require_one_source(const PlanArguments& arguments, const Context& context) {
  if (context.planned.empty()) {
    if (!arguments.options.scan.inputs.empty()) return;
    throw Error(ErrorKind::invalid_argument, "a source is required; see octavo plan --help");
  }
  if (!arguments.is_scan_told()) return;
  throw Error(ErrorKind::invalid_argument,
              "what is computed has its sources and options behind --, those of a build do not go "
              "with it");
}

PlanScanOptions options_of(const PlanArguments& arguments, const Context& context) {
  require_one_source(arguments, context);
  PlanScanOptions options = arguments.options;
  if (!context.planned.empty()) {
    options.words.assign(context.planned.begin() + 1, context.planned.end());
    options.work = parse_work(options.words);
  }
  return options;
}

std::string groups_of_parts(const PlanResult& plan) {
  if (plan.bands > 1) return fmt::format(", of which {} share each group", plan.bands);
  const std::int64_t fewest = plan.group_count / plan.part_count;
  if (fewest == plan.groups_per_part) return " of " + counted_text(fewest, "group");
  return fmt::format(" of {} or {} groups", fewest, plan.groups_per_part);
}

std::string plan_words(const PlanResult& plan, const std::string& path) {
  std::string stem = path;
  if (stem.ends_with(".plan")) stem.resize(stem.size() - 5);
  constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
  const std::string file = one_line(shell_path(path));
  std::string text = fmt::format(
      "plan      {} voxels of {}, {}; {} of {}, {} each\n", size_text(plan.volume.size),
      voxel_type_name(plan.volume.type), bytes_text(plan.raw_bytes),
      counted_text(plan.group_count, "group"), counted_text(plan.planes_per_group, "plane"),
      bytes_text(plan.group_bytes));
  if (!plan.can_seek) {
    text += "source    is compressed as one stream: every part reads it from its start\n";
  }
  text += fmt::format("parts     {}{}; each needs {} of memory with 1 thread{}\n",
                      plan.part_count, groups_of_parts(plan), bytes_text(plan.part_memory_bytes),
                      plan.is_in_bands ? ", in bands" : "");
  const std::string limit =
      plan.is_in_bands ? fmt::format(" --max-memory {}", plan.part_memory_bytes) : "";
  text += fmt::format(
      "next      sbatch --array=0-{} --mem={}G --wrap {}\n"
      "          octavo join {} parts/ -o {}\n",
      plan.part_count - 1, (plan.part_memory_bytes + kGiB - 1) / kGiB,
      quoted_words("octavo part " + file + " -j 1" + limit + " -o parts/"), file,
      one_line(shell_path(stem + ".8vo")));
  return text;
}

nlohmann::ordered_json plan_json(const PlanResult& plan, const PlanScanOptions& options) {
  return {{"output", options.scan.output.path},
          {"size", size_json(plan.volume.size)},
          {"type", voxel_type_name(plan.volume.type)},
          {"kind", word_of(plan.kind)},
          {"raw_bytes", plan.raw_bytes},
          {"groups", plan.group_count},
          {"planes_per_group", plan.planes_per_group},
          {"group_bytes", plan.group_bytes},
          {"parts", plan.part_count},
          {"asked_parts", json_of(options.parts)},
          {"groups_per_part", plan.groups_per_part},
          {"bands", plan.bands},
          {"asked_bands", json_of(options.bands)},
          {"part_memory_bytes", plan.part_memory_bytes},
          {"in_bands", plan.is_in_bands},
          {"thread_bytes", plan.thread_bytes},
          {"files", plan.file_count},
          {"reads_from_start", !plan.can_seek}};
}

int run_plan(const PlanArguments& arguments, Context& context) {
  const PlanResult plan = run_task(plan_scan, options_of(arguments, context), context);
  const std::string& path = arguments.options.scan.output.path;
  print_result(context, plan_json(plan, arguments.options), plan_words(plan, path));
  return kExitDone;
}

}  // namespace

void add_plan(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kPlanText, run_plan);
  PlanScanOptions& options = arguments.options;
  arguments.is_scan_told =
      verb.add_together([verb, &options] { add_build_options(verb, options.scan); });
  verb.add_output(options.scan.output, "The plan to write, NAME.plan");
  Option parts = verb.add_option("--parts N", options.parts,
                                 "Into how many parts, at most one for each group of slices")
                     .check(whole_within(1));
  Option part_size = verb.add_parsed("--part-size BYTES", options.part_bytes, parse_bytes,
                                     "Parts of so many bytes of voxels at most (8G). Default: 4G")
                         .excludes(parts);
  verb.add_option("--bands N", options.bands, "So many parts share each group of slices")
      .check(whole_within(1))
      .excludes(parts)
      .excludes(part_size);
  verb.add_option("--source-root FOLDER", options.source_root,
                  "Where relative paths of the plan begin; default: at its folder");
  verb.add_word("--check HOW", options.check,
                {{"times", FileCheck::times}, {"content", FileCheck::content}},
                "What tells that a file was changed: its length and time, or all its bytes");
}

}  // namespace octavo::cli
