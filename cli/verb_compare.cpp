// octavo compare: are two volumes the same, in place and in every voxel?
#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/scan_options.h"
#include "common/task_run.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/files/compare.h"
#include "text/comparison_words.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kCompareText = {
    "compare", "Compare geometry and voxels of two volumes.",
    "Either side is an .8vo file, a URL of one, or any source that build reads. Stored values are\n"
    "compared where the rescales agree, real values otherwise. Exit code 1 when they differ. Two\n"
    "files whose ends state the same digest of their voxels are the same without reading any;\n"
    "--voxels reads them all the same.\n"
    "With --labels, two label maps, A and B: the voxels of each label in A, in B and in both, and\n"
    "its Dice coefficient (twice those in both over the sum of the others, 1 where all agree).\n\n"
    "Examples:\n"
    "  octavo compare old.8vo new.8vo\n"
    "  octavo compare head.8vo scans/head/\n"
    "  octavo compare small.8vo scans/head/ --max-error 2\n"
    "  octavo compare reference.8vo found.8vo --labels"};

struct CompareArguments {
  CompareOptions volumes;
  bool are_labels = false;
};

std::string difference_text(const CompareOptions& options, const CompareResult& result) {
  std::string text =
      fmt::format("{} and {} differ\n", shown_path(options.a), shown_path(options.b));
  for (const std::string& line : comparison_lines(result.comparison, result.a, result.b)) {
    text += "  " + line + "\n";
  }
  return text;
}

int run_volumes(const CompareOptions& options, Context& context) {
  const CompareResult result = run_task(compare_volumes, options, context);
  const bool is_equal = result.comparison.is_equal();
  const std::string text = is_equal ? fmt::format("{} and {} are {}\n", shown_path(options.a),
                                                  shown_path(options.b), equal_text(result))
                                    : difference_text(options, result);
  print_finding(context, is_equal, comparison_json(result.comparison), text);
  return is_equal ? kExitDone : kExitDifferent;
}

std::string labels_text(const CompareOptions& options, const CompareLabelsResult& result) {
  const std::vector<LabelAgreement>& all = result.agreements;
  const auto alike = std::count_if(all.begin(), all.end(),
                                   [](const LabelAgreement& one) { return one.dice() == 1; });
  const std::string text = fmt::format(
      "A = {}, B = {}: {} label{}, {} of them the same in both\n", shown_path(options.a),
      shown_path(options.b), all.size(), all.size() == 1 ? "" : "s", alike);
  return all.empty() ? text : text + agreement_table(result);
}

int run_labels(const CompareOptions& options, Context& context) {
  require_scan_for_options({options.a, options.b}, options.scan);
  const CompareLabelsOptions of_labels = {options.a, options.b};
  const CompareLabelsResult result = run_task(compare_labels, of_labels, context);
  print_finding(context, result.is_equal,
                {{"equal", result.is_equal}, {"labels", agreements_json(result)}},
                labels_text(options, result));
  return result.is_equal ? kExitDone : kExitDifferent;
}

int run_compare(const CompareArguments& arguments, Context& context) {
  return arguments.are_labels ? run_labels(arguments.volumes, context)
                              : run_volumes(arguments.volumes, context);
}

}  // namespace

void add_compare(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kCompareText, run_compare);
  CompareOptions& options = arguments.volumes;
  verb.add_option("a VOLUME", options.a, "The first volume").required();
  verb.add_option("b VOLUME", options.b, "The second volume").required();
  Option labels =
      verb.add_flag("--labels", arguments.are_labels, "Compare two label maps label by label");
  verb.add_parsed("--max-error,--tolerance E", options.max_error, parse_number,
                  "Largest difference, in real units, that counts as equal")
      .default_str("0")
      .excludes(labels);
  verb.add_flag("--voxels", options.voxels, "Read all voxels, whatever the digests of files say")
      .excludes(labels);
  add_scan_options(verb, options.scan);
}

}  // namespace octavo::cli
