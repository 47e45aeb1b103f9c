// octavo codes: the o-codes of what a file holds: label maps by their tree, other voxels condensed
// plane by plane.

#include "common/codes_arguments.h"
#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCodesText = {
    "codes", "Show a mask or label map as the leaves of an octree: o-codes and counts.",
    "Background (0) gets no leaf. A grey file needs --range, which makes a mask of it, unless\n"
    "octavo condense made it: then every cube is a leaf, its value as it is stored. With\n"
    "--list every leaf is printed as CODE VALUE (mixed: in post-order) or LEVEL CODE VALUE\n"
    "(linear: level by level; the root has no digits and is shown as -). --neighbors says what\n"
    "one cube itself is, and prints what lies beside it in the 26 directions: the leaf of the\n"
    "same or a larger size, 'smaller' where there are only smaller leaves, 'background' or\n"
    "'outside'; - is the root in both notations.\n\n"
    "Examples:\n"
    "  octavo codes aal.8vo\n"
    "  octavo codes aal.8vo --label 37 --list --notation linear\n"
    "  octavo codes aal.8vo --label Hippocampus_L --counts\n"
    "  octavo codes aal.8vo --neighbors 20465788\n"
    "  octavo codes head.8vo --range 300:3000"};

int run_codes(const CodesArguments& arguments, Context& context) {
  const CodesOptions options = codes_options(arguments, context);
  print_codes(run_task(codes, options, context), arguments, context);
  return kExitDone;
}

}  // namespace

void add_codes(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kCodesText, run_codes);
  add_codes_options(verb, arguments);
}

}  // namespace octavo::cli
