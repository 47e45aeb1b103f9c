// octavo components: what is connected in a mask, as a label map and a table.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <tuple>

#include "common/failure.h"
#include "common/options.h"
#include "common/part_options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/components/components_in_parts.h"
#include "octavo/tasks/structure/region_rows.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kComponentsText = {
    "components", "Find the connected parts of a mask.",
    "A mask is every voxel of a label map that is not 0. Parts are numbered from 1, the largest\n"
    "first. The label map written with -o is a mask for other verbs as well.\n\n"
    "--part I/N finds the components of a part of a large mask, as a task of an array of N does,\n"
    "and writes what a join needs of them with -o. --join gives the table of all parts, with the\n"
    "same numbers as components gives in one run; its -o writes those numbers to a file. With it\n"
    "--numbers makes the label map, here or behind plan --, on many machines. A part holds the\n"
    "mask of its planes alone in memory: more parts need less.\n\n"
    "Examples:\n"
    "  octavo components bone.8vo\n"
    "  octavo components bone.8vo --keep-largest 1 -o skull.8vo\n"
    "  octavo components pores.8vo --connectivity 26 --min-mm3 0.5 -o pores-labels.8vo --json\n"
    "  octavo components pores.8vo --part 3/8 -o found-3.json\n"
    "  octavo components pores.8vo --join found-*.json -o pores.numbers\n"
    "  octavo plan -o labels.plan -- components pores.8vo --numbers pores.numbers"};

struct ComponentsArguments {
  ComponentsOptions options;
  std::size_t rows = 20;
  std::string numbers;
  PartArguments parts;
};

ComponentsOptions options_of(const ComponentsArguments& arguments, const Context& context) {
  // A row as a tree of JSON and as text, or as text alone.
  constexpr std::uint64_t kJsonBytes = 2048;
  constexpr std::uint64_t kTextBytes = 256;
  ComponentsOptions options = arguments.options;
  if (!context.json) options.max_rows = arguments.rows;
  options.bytes_per_row = context.json ? kJsonBytes : kTextBytes;
  return options;
}

nlohmann::ordered_json report_json(const ComponentsOptions& options,
                                   const ComponentsResult& result) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const ComponentRow& row : result.rows) {
    objects.push_back(json_of(facts_of(region_row(row))));
  }
  nlohmann::ordered_json report = {
      {"components", result.found}, {"kept", result.kept}, {"objects", std::move(objects)}};
  if (options.output) {
    report["output"] = options.output->path;
    report["file_bytes"] = result.file_bytes;
  }
  return report;
}

std::string table_text(const ComponentsOptions& options, const ComponentsResult& result) {
  std::string text = fmt::format("{}: {}, {} kept{}\n", shown_path(options.input),
                                 count_of(result.found, "component"), count_of(result.kept),
                                 options.output ? " in " + shown_path(options.output->path) : "");
  if (!result.rows.empty()) {
    text += fmt::format("{:>7} {:>14} {:>14}  {:<26} {}\n", "label", "voxels", "mm3",
                        result.rows.front().mm3 ? "centroid mm (x, y, z)" : "centroid voxels",
                        "box");
  }
  for (const ComponentRow& row : result.rows) {
    const Point3 center = row.centroid_mm.value_or(row.centroid);
    text += fmt::format("{:>7} {:>14} {:>14}  {:<26} {}\n", row.label, count_of(row.voxels),
                        row.mm3 ? fmt::format("{:.2f}", *row.mm3) : "-",
                        fmt::format("{:.1f}, {:.1f}, {:.1f}", center[0], center[1], center[2]),
                        box_text(row.box));
  }
  const std::size_t left = result.kept - result.rows.size();
  if (left == 0) return text;
  return text + fmt::format("... {} more; --rows {} shows all\n", count_of(left), result.kept);
}

int run_components_part(const ComponentsArguments& arguments, Context& context) {
  PartArguments parts = arguments.parts;
  parts.output = arguments.options.output;
  const ComponentsPartOptions options = {arguments.options.input, arguments.options.connectivity,
                                         *parts.part, parts.output_of_part()};
  const std::size_t found = run_task(components_of_part, options, context);
  print_part_result(context, options.output, options.part, {{"components", found}},
                    count_of(found, "component"));
  return kExitDone;
}

int run_numbered(const ComponentsArguments& arguments, Context& context) {
  const auto& [input, output] = std::tie(arguments.options.input, arguments.options.output);
  if (!output) {
    throw Error(ErrorKind::invalid_argument, "--numbers needs -o FILE for the label map");
  }
  const LabelComponentsOptions options = {input, arguments.numbers, *output};
  const LabeledComponents result = run_task(label_components, options, context);
  print_result(
      context,
      {{"components", result.found},
       {"kept", result.kept},
       {"output", output->path},
       {"file_bytes", result.file_bytes}},
      fmt::format("{}: {}, {} kept in {}\n", shown_path(input),
                  count_of(result.found, "component"), count_of(result.kept),
                  shown_path(output->path)));
  return kExitDone;
}

ComponentsResult found_components(const ComponentsArguments& arguments, Context& context) {
  const ComponentsOptions options = options_of(arguments, context);
  if (arguments.parts.join.empty()) return run_task(components, options, context);
  return run_task(join_components, JoinComponentsOptions{options, arguments.parts.join}, context);
}

int run_components(const ComponentsArguments& arguments, Context& context) {
  if (arguments.parts.part) return run_components_part(arguments, context);
  if (!arguments.numbers.empty()) return run_numbered(arguments, context);
  const ComponentsResult result = found_components(arguments, context);
  // One of them alone, since there may be millions of rows.
  print_result(
      context,
      context.json ? report_json(arguments.options, result) : nlohmann::ordered_json::object(),
      context.json ? "" : table_text(arguments.options, result));
  return kExitDone;
}

}  // namespace

void add_components(CLI::App& app, Context& context) {
  auto [verb, arguments] = add_verb(app, context, kComponentsText, run_components);
  ComponentsOptions& options = arguments.options;
  add_mask_input(verb, options.input);
  verb.add_output_option("-o,--output FILE", options.output,
                         "The .8vo label map to write; with --part or --join, what is found");
  Option connectivity = add_connectivity(
      verb, options.connectivity, "Voxels are connected by faces (6), edges (18) or corners (26)");
  Option largest =
      verb.add_option("--keep-largest N", options.keep_largest, "Keep only the N largest")
          .check(whole_within(1));
  Option smallest =
      verb.add_option("--min-mm3 V", options.min_mm3, "Keep only those of this volume or more")
          .check(not_negative());
  Option rows = verb.add_option("--rows N", arguments.rows, "Rows of the table, at most")
                    .check(whole_within(0))
                    .capture_default_str();
  const auto [part, join] = add_part_and_join(verb, arguments.parts);
  Option numbers = verb.add_option("--numbers FILE", arguments.numbers,
                                   "Write the label map with the numbers of a join")
                       .group(kPartGroup);
  for (Option option : {part, join, connectivity, largest, smallest, rows}) {
    numbers.excludes(option);
  }
  for (Option option : {largest, smallest, rows}) option.excludes(part);
}

}  // namespace octavo::cli
