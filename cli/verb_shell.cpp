// octavo shell: the leaves of a mask that are not hidden among others.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/shell.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kShellText = {
    "shell", "Keep the leaves of a mask that lie at its surface.",
    "A leaf is left out when leaves of its size or larger cover all six of its sides. A mask is\n"
    "every voxel of a label map that is not 0.\n\n"
    "Examples:\n"
    "  octavo shell bone.8vo -o bone-shell.8vo\n"
    "  octavo shell bone.8vo --json"};

nlohmann::ordered_json report_json(const ShellOptions& options, const ShellResult& result) {
  nlohmann::ordered_json report = {{"leaves", result.leaves},
                                   {"kept", result.kept},
                                   {"removed", result.leaves - result.kept},
                                   {"voxels", result.voxels},
                                   {"mm3", json_of(mm3_of(result.voxels, result.volume))}};
  if (options.output) {
    report["output"] = options.output->path;
    report["file_bytes"] = result.file_bytes;
  }
  return report;
}

int run_shell(const ShellOptions& options, Context& context) {
  const ShellResult result = run_task(shell, options, context);
  print_result(context, report_json(options, result),
               fmt::format("{}: {} of {} leaves lie at the surface, {} removed; {}\n",
                           shown_path(options.output ? options.output->path : options.input),
                           count_text(result.kept), count_text(result.leaves),
                           count_text(result.leaves - result.kept),
                           volume_text(result.voxels, result.volume)));
  return kExitDone;
}

}  // namespace

void add_shell(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kShellText, run_shell);
  add_mask_input(verb, options.input);
  verb.add_output_option("-o,--output FILE", options.output, "The .8vo mask to write");
}

}  // namespace octavo::cli
