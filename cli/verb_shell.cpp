// octavo shell: the leaves of a mask that are not hidden among others.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/shell.h"
#include "octavo/tasks/volume_facts.h"
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

struct ShellArguments {
  std::string input;
  std::string output;
};

nlohmann::ordered_json report_json(const ShellArguments& arguments, const ShellResult& result) {
  nlohmann::ordered_json report = {{"leaves", result.leaves},
                                   {"kept", result.kept},
                                   {"removed", result.leaves - result.kept},
                                   {"voxels", result.voxels},
                                   {"mm3", optional_json(mm3_of(result.voxels, result.volume))}};
  if (!arguments.output.empty()) {
    report["output"] = arguments.output;
    report["file_bytes"] = result.file_bytes;
  }
  return report;
}

int run_shell(const ShellArguments& arguments, Context& context) {
  ShellOptions options;
  options.input = arguments.input;
  if (!arguments.output.empty()) options.output = {arguments.output, context.force};
  const ShellResult result = run_task(shell, options, context);
  print_result(
      context, report_json(arguments, result),
      fmt::format("{}: {} of {} leaves lie at the surface, {} removed; {}\n",
                  arguments.output.empty() ? public_name(arguments.input) : arguments.output,
                  count_text(result.kept), count_text(result.leaves),
                  count_text(result.leaves - result.kept),
                  volume_text(result.voxels, result.volume)));
  return kExitDone;
}

}  // namespace

void add_shell(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<ShellArguments>();
  Verb verb = add_verb(app, context, kShellText,
                            [arguments, &context] { return run_shell(*arguments, context); });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")->type_name("FILE");
}

}  // namespace octavo::cli
