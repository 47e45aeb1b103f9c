// octavo part: some of the parts of a plan.
#include <fmt/format.h>

#include <cstdlib>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/text.h"
#include "octavo/tasks/parts/make_parts.h"
#include "parts/planned_work.h"
#include "text/fact_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kPartText = {
    "part", "Make parts of a planned build.",
    "A part depends on its plan and its slices alone, and made twice it has the same bytes: parts\n"
    "are made in any order, anywhere, as often as you like. A part that stands whole is kept; one\n"
    "that is damaged is made anew. So the same job, started again, makes what is missing.\n\n"
    "Parts count from 0. Without --part the number comes from the scheduler, and a line says from\n"
    "where: SLURM_ARRAY_TASK_ID, PBS_ARRAY_INDEX, LSB_JOBINDEX and SGE_TASK_ID (which count from\n"
    "1), AWS_BATCH_JOB_ARRAY_INDEX, JOB_COMPLETION_INDEX. Ranks of Open MPI, PMIx and srun share\n"
    "the parts: rank r of n makes parts r, r + n, and so on. An array of Slurm or Grid Engine\n"
    "that has as many tasks as there are parts may begin at any number.\n\n"
    "A part has its name only when it is whole and on disk.\n\n"
    "Examples:\n"
    "  octavo part scan.plan --part 7 -o parts/\n"
    "  octavo part scan.plan --parts 3,17-19 -o parts/\n"
    "  sbatch --array=0-116 --mem=5G --wrap 'octavo part scan.plan -j 1 -o parts/'"};

struct PartVerbArguments {
  MakePartsOptions options;
  std::string part;
};

nlohmann::ordered_json made_parts_json(const MakePartsResult& result) {
  const auto part_json = [](const MadePart& part) -> nlohmann::ordered_json {
    return {{"part", part.number},
            {"output", part.path},
            {"file_bytes", part.file_bytes},
            {"was_there", part.was_there}};
  };
  return {{"part_count", result.part_count},
          {"number_from", text_json(result.scheduled ? result.scheduled->variable : "")},
          {"parts", json_list(result.parts, part_json)}};
}

int run_part(const PartVerbArguments& arguments, Context& context) {
  MakePartsOptions options = arguments.options;
  if (!arguments.part.empty()) options.parts = arguments.part;
  options.variables = [](const char* name) { return std::getenv(name); };
  options.parser = parse_work;
  options.overwrite = context.force;
  const MakePartsResult result = run_task(make_parts, options, context);
  std::string text;
  for (const MadePart& part : result.parts) {
    const std::string what =
        part.was_there ? " is there already"
                       : fmt::format(": {}, {}", shown_path(part.path),
                                     bytes_text(part.file_bytes));
    text += fmt::format("part {} of {}{}\n", part.number, result.part_count, what);
  }
  print_result(context, made_parts_json(result), text);
  return kExitDone;
}

}  // namespace

void add_part(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kPartText, run_part);
  verb.add_option("plan PLAN", arguments.options.plan, "A plan that octavo plan has written")
      .required();
  Option part =
      verb.add_option("--part I", arguments.part, "The number of one part").check(whole_within(0));
  verb.add_option("--parts LIST", arguments.options.parts, "Several parts: 3,17-19").excludes(part);
  verb.add_option("-o,--output FOLDER", arguments.options.folder,
                  "The folder for the parts; default: that of the plan");
  verb.add_option("--source-root FOLDER", arguments.options.source_root,
                  "Where relative paths of the plan begin on this machine; of a plan "
                  "without any, the folder of all files of the source");
}

}  // namespace octavo::cli
