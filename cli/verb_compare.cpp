// octavo compare: are two volumes the same, in place and in every voxel?
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/inputs.h"
#include "common/label_trees.h"
#include "common/options.h"
#include "common/plane_compare.h"
#include "common/progress_line.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kText = {
    "compare", "Compare geometry and voxels of two volumes.",
    "Either side is an .8vo file, a URL of one, or any source that build reads. Stored values are\n"
    "compared where the rescales agree, real values otherwise. Exit code 1 when they differ.\n"
    "With --labels, two label maps, A and B: the voxels of each label in A, in B and in both, and\n"
    "its Dice coefficient (twice those in both over the sum of the others, 1 where all agree).\n\n"
    "Examples:\n"
    "  octavo compare old.8vo new.8vo\n"
    "  octavo compare head.8vo scans/head/\n"
    "  octavo compare small.8vo scans/head/ --max-error 2\n"
    "  octavo compare truth.8vo found.8vo --labels"};

struct Arguments {
  std::string a;
  std::string b;
  std::string max_error = "0";
  bool labels = false;
  SourceArguments source;
};

std::string equal_text(const Comparison& c, const VolumeDescription& a,
                       const VolumeDescription& b) {
  std::string text =
      fmt::format("the same: {}, {}", counted_text(c.voxels, "voxel"),
                  c.is_real_units ? "real values compared" : "stored values compared");
  if (c.max_difference > 0) {
    text += fmt::format(", largest difference {}", number_text(c.max_difference));
  }
  if (!c.is_same_type) {
    text += fmt::format(", {} against {}", voxel_type_name(a.type), voxel_type_name(b.type));
  }
  if (!c.is_place_known) text += ", places not compared: a spacing is not known";
  else if (c.shift_mm > 0) text += fmt::format(", places within {} mm", number_text(c.shift_mm));
  return text;
}

int run_compare(const Arguments& arguments, Context& context) {
  const double max_error = parse_number(arguments.max_error, "--max-error");
  require_scan_for_options({arguments.a, arguments.b}, arguments.source);
  if (arguments.labels) {
    return compare_labels(arguments.a, arguments.b, context) ? kExitDone : kExitDifferent;
  }
  const auto a = open_planes({arguments.a}, arguments.source, context, OptionsOf::any_source);
  const auto b = open_planes({arguments.b}, arguments.source, context, OptionsOf::any_source);
  Comparison result;
  {
    ProgressLine progress(context);
    result = compare_volumes(
        *a, *b, compared_tolerance(a->description(), b->description(), max_error), progress);
  }
  if (context.json) {
    print_json(comparison_json(result));
  } else if (!result.is_equal()) {
    std::string text = fmt::format("{} and {} differ\n", arguments.a, arguments.b);
    for (const std::string& line : comparison_lines(result, a->description(), b->description())) {
      text += "  " + line + "\n";
    }
    print(text);
  } else if (!context.quiet) {
    print(fmt::format("{} and {} are {}\n", arguments.a, arguments.b,
                      equal_text(result, a->description(), b->description())));
  }
  return result.is_equal() ? kExitDone : kExitDifferent;
}

}  // namespace

void add_compare(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<Arguments>();
  Verb verb = add_verb(app, context, kText,
                            [arguments, &context] { return run_compare(*arguments, context); });
  verb.add_option("a", arguments->a, "The first volume")->type_name("VOLUME")->required();
  verb.add_option("b", arguments->b, "The second volume")->type_name("VOLUME")->required();
  Option labels =
      verb.add_flag("--labels", arguments->labels, "Compare two label maps label by label");
  verb.add_option("--max-error,--tolerance", arguments->max_error,
                  "Largest difference, in real units, that counts as equal")
      ->type_name("E")
      ->capture_default_str()
      ->excludes(labels);
  add_source_options(verb, arguments->source);
}

}  // namespace octavo::cli
