// octavo shell: the leaves of a mask that are not hidden among others.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/masks.h"
#include "common/options.h"
#include "octavo/ops/mask/shell.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "shell", "Keep the leaves of a mask that lie at its surface.",
    "A leaf is left out when leaves of its size or larger cover all six of its sides. A mask is\n"
    "every voxel of a label map that is not 0.\n\n"
    "Examples:\n"
    "  octavo shell bone.8vo -o bone-shell.8vo\n"
    "  octavo shell bone.8vo --json"};

struct Arguments {
  std::string input;
  std::string output;
};

int run_shell(const Arguments& arguments, Context& context) {
  if (!arguments.output.empty()) {
    require_computed_output(arguments.output, {arguments.input}, context);
  }
  const OpenedMask mask = open_mask(arguments.input, context);
  require_memory(3 * mask.tree.memory_bytes(), "the mask and its shell", context);
  std::optional<MaskTree> made;
  on_threads(context, [&] { made = shell(mask.tree); });
  const std::int64_t leaves = leaf_count(mask.tree);
  const std::int64_t kept = leaf_count(*made);
  const std::uint64_t voxels = made->voxel_count();
  nlohmann::ordered_json result = {{"leaves", leaves},
                                   {"kept", kept},
                                   {"removed", leaves - kept},
                                   {"voxels", voxels},
                                   {"mm3", mm3_json(voxels, mask.volume())}};
  if (!arguments.output.empty()) {
    const BuildResult built =
        write_mask(*made, mask.volume(), {{"operation", "shell"}}, arguments.output, context);
    result["output"] = arguments.output;
    result["file_bytes"] = built.file_bytes;
  }
  result["warnings"] = context.warnings;
  if (context.json) {
    print_json(result);
  } else if (!context.quiet) {
    print(fmt::format("{}: {} of {} leaves lie at the surface, {} removed; {}\n",
                      arguments.output.empty() ? arguments.input : arguments.output,
                      count_text(kept), count_text(leaves), count_text(leaves - kept),
                      volume_text(voxels, mask.volume())));
  }
  return kExitDone;
}

}  // namespace

void add_shell(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_shell(*arguments, context); });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo mask to write")->type_name("FILE");
}

}  // namespace octavo::cli
