// octavo threshold: a mask, or classes, from the values of a volume.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/label_option.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/tasks/threshold.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/value_range_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kThresholdText = {
    "threshold", "Make a mask of the voxels whose value lies in a range.",
    "Ranges are in real units (HU), both ends included; an end left out is open, but NaN and\n"
    "infinities are in no range. Several ranges and tissues add up, and so do labels of a label\n"
    "map. --class makes a label map of several classes in one pass; where classes overlap the one\n"
    "named first counts. Bricks whose minimum and maximum decide are not decoded.\n\n"
    "Tissues, in HU, ends included: air (:-900), lung (-900:-500), fat (-190:-30),\n"
    "soft (-30:225), contrast (130:600), bone (226:).\n\n"
    "Examples:\n"
    "  octavo threshold head.8vo --range 226: -o bone.8vo\n"
    "  octavo threshold chest.8vo --tissue lung --tissue air -o gas.8vo\n"
    "  octavo threshold head.8vo --class 1=:-300 --class 2=-300:225 --class 3=226: -o classes.8vo\n"
    "  octavo threshold atlas.8vo --label 17 --label Thalamus_L -o regions.8vo"};

struct ThresholdArguments {
  std::string input;
  std::string output;
  std::vector<std::string> ranges;
  std::vector<std::string> tissues;
  std::vector<std::string> labels;
  std::vector<std::string> classes;
  bool stored = false;
};

ValueClass parse_class(const std::string& text) {
  const std::size_t equals = text.find('=');
  const std::int64_t label =
      equals == std::string::npos ? 0 : parse_integer(text.substr(0, equals), "--class");
  if (label < 1 || label > 255) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--class: '{}'; expected LABEL=LOW:HIGH with a label of 1 to 255",
                            escaped(text)));
  }
  return {label, parse_range(text.substr(equals + 1), "--class")};
}

ThresholdOptions options_of(const ThresholdArguments& arguments, const Context& context) {
  if (arguments.ranges.empty() && arguments.tissues.empty() && arguments.labels.empty() &&
      arguments.classes.empty()) {
    throw Error(ErrorKind::invalid_argument,
                "threshold needs --range LOW:HIGH, --tissue, --label or --class");
  }
  ThresholdOptions options;
  options.input = arguments.input;
  options.output = {arguments.output, context.force};
  for (const std::string& text : arguments.ranges) {
    options.ranges.push_back(parse_range(text, "--range"));
  }
  options.tissues = arguments.tissues;
  options.labels = parse_labels(arguments.labels);
  for (const std::string& text : arguments.classes) options.classes.push_back(parse_class(text));
  options.is_stored = arguments.stored;
  return options;
}

std::string report_text(const ThresholdArguments& arguments, const ThresholdResult& result) {
  const auto all = static_cast<double>(result.volume.size.voxel_count());
  std::string text;
  for (const LabelVolume& object : result.objects) {
    text += fmt::format("{}: {}{} ({:.3g} % of the volume)\n", arguments.output,
                        arguments.classes.empty() ? "" : fmt::format("label {}: ", object.label),
                        volume_text(object.voxels, result.volume),
                        100 * static_cast<double>(object.voxels) / all);
  }
  return text.empty() ? arguments.output + ": no voxel is in any class\n" : text;
}

nlohmann::ordered_json report_json(const ThresholdArguments& arguments,
                                   const ThresholdResult& result) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const LabelVolume& object : result.objects) {
    objects.push_back({{"label", object.label},
                       {"voxels", object.voxels},
                       {"mm3", optional_json(mm3_of(object.voxels, result.volume))}});
  }
  return {{"output", arguments.output},
          {"file_bytes", result.file_bytes},
          {"objects", objects}};
}

int run_threshold(const ThresholdArguments& arguments, Context& context) {
  const ThresholdResult result = run_task(threshold, options_of(arguments, context), context);
  print_result(context, report_json(arguments, result), report_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_threshold(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<ThresholdArguments>();
  Verb verb = add_verb(app, context, kThresholdText,
                            [arguments, &context] { return run_threshold(*arguments, context); });
  verb.add_input(arguments->input);
  verb.add_output(arguments->output, "The .8vo mask to write");
  Option range = verb.add_option("--range", arguments->ranges, "Values LOW:HIGH to take");
  range->type_name("LOW:HIGH")->allow_extra_args(false);
  Option tissue = verb.add_option("--tissue", arguments->tissues, "A range by name");
  tissue->type_name("NAME")->allow_extra_args(false)->check(one_of(tissue_names()));
  Option label = add_label_option(verb, arguments->labels, "A label of a label map");
  verb.add_option("--class", arguments->classes, "Values that get a label: LABEL=LOW:HIGH")
      ->type_name("N=LOW:HIGH")
      ->allow_extra_args(false)
      ->excludes(range)
      ->excludes(tissue)
      ->excludes(label);
  verb.add_flag("--stored", arguments->stored, "Ranges are stored values instead of real ones")
      ->excludes(tissue);
}

}  // namespace octavo::cli
