// octavo threshold: a mask, or classes, from the values of a volume.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/threshold.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"
#include "text/quantities.h"
#include "text/value_range_words.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kThresholdText = {
    "threshold", "Make a mask of the voxels whose value lies in a range.",
    "Ranges are in real units (HU), both ends included; an end left out is open, but NaN and\n"
    "infinities are in no range. An end is the number that is read: of float32 voxels it is\n"
    "rounded to float32, and where a slope makes decimals of integers, one that misses it by a\n"
    "rounding of float32 is included. Several ranges and tissues add up, and so do labels of a\n"
    "label map. --class makes a label map of several classes in one pass; where classes overlap\n"
    "the one named first counts. Bricks whose minimum and maximum decide are not decoded.\n\n"
    "Tissues, in HU, ends included: air (:-900), lung (-900:-500), fat (-190:-30),\n"
    "soft (-30:225), contrast (130:600), bone (226:).\n\n"
    "Examples:\n"
    "  octavo threshold head.8vo --range 226: -o bone.8vo\n"
    "  octavo threshold chest.8vo --tissue lung --tissue air -o gas.8vo\n"
    "  octavo threshold head.8vo --class 1=:-300 --class 2=-300:225 --class 3=226: -o classes.8vo\n"
    "  octavo threshold atlas.8vo --label 17 --label Thalamus_L -o regions.8vo"};

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

void require_values(const ThresholdOptions& options) {
  if (!options.ranges.empty() || !options.tissues.empty() || !options.labels.is_empty() ||
      !options.classes.empty()) {
    return;
  }
  throw Error(ErrorKind::invalid_argument,
              "threshold needs --range LOW:HIGH, --tissue, --label or --class");
}

std::string report_text(const ThresholdOptions& options, const ThresholdResult& result) {
  const auto all = static_cast<double>(result.volume.size.voxel_count());
  std::string text;
  for (const LabelVolume& object : result.objects) {
    text += fmt::format("{}: {}{} ({:.3g} % of the volume)\n", shown_path(options.output.path),
                        options.classes.empty() ? "" : fmt::format("label {}: ", object.label),
                        volume_text(object.voxels, result.volume),
                        100 * static_cast<double>(object.voxels) / all);
  }
  return text.empty() ? shown_path(options.output.path) + ": no voxel is in any class\n" : text;
}

nlohmann::ordered_json report_json(const ThresholdOptions& options, const ThresholdResult& result) {
  const auto object_json = [&](const LabelVolume& object) -> nlohmann::ordered_json {
    return {{"label", object.label},
            {"voxels", object.voxels},
            {"mm3", json_of(mm3_of(object.voxels, result.volume))}};
  };
  return {{"output", options.output.path},
          {"file_bytes", result.file_bytes},
          {"objects", json_list(result.objects, object_json)}};
}

int run_threshold(const ThresholdOptions& options, Context& context) {
  require_values(options);
  const ThresholdResult result = run_task(threshold, options, context);
  print_result(context, report_json(options, result), report_text(options, result));
  return kExitDone;
}

}  // namespace

void add_threshold(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kThresholdText, run_threshold);
  verb.add_input(options.input);
  verb.add_output(options.output, "The .8vo mask to write");
  Option range =
      verb.add_list("--range LOW:HIGH", options.ranges, parse_range, "Values LOW:HIGH to take");
  Option tissue = add_tissues(verb, options.tissues);
  Option label = add_label_option(verb, options.labels, "A label of a label map");
  verb.add_list("--class N=LOW:HIGH", options.classes, parse_class,
                "Values that get a label: LABEL=LOW:HIGH")
      .excludes(range)
      .excludes(tissue)
      .excludes(label);
  verb.add_flag("--stored", options.is_stored, "Ranges are stored values instead of real ones")
      .excludes(tissue);
}

}  // namespace octavo::cli
