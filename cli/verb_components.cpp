// octavo components: what is connected in a mask, as a label map and a table.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/text.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/components.h"
#include "octavo/tasks/volume_facts.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kComponentsText = {
    "components", "Find the connected parts of a mask.",
    "A mask is every voxel of a label map that is not 0. Parts are numbered from 1, the largest\n"
    "first. The label map written with -o is a mask for other verbs as well.\n\n"
    "Examples:\n"
    "  octavo components bone.8vo\n"
    "  octavo components bone.8vo --keep-largest 1 -o skull.8vo\n"
    "  octavo components pores.8vo --connectivity 26 --min-mm3 0.5 -o pores-labels.8vo --json"};

struct ComponentsArguments {
  std::string input;
  std::string output;
  int connectivity = 6;
  std::int64_t keep_largest = 0;
  double min_mm3 = 0;
  std::size_t rows = 20;
};

ComponentsOptions options_of(const ComponentsArguments& arguments, const Context& context) {
  // A row as a tree of JSON and as text, or as text alone.
  constexpr std::uint64_t kJsonBytes = 2048;
  constexpr std::uint64_t kTextBytes = 256;
  ComponentsOptions options;
  options.input = arguments.input;
  if (!arguments.output.empty()) options.output = {arguments.output, context.force};
  options.connectivity = static_cast<Connectivity>(arguments.connectivity);
  options.keep_largest = arguments.keep_largest;
  options.min_mm3 = arguments.min_mm3;
  if (!context.json) options.max_rows = arguments.rows;
  options.bytes_per_row = context.json ? kJsonBytes : kTextBytes;
  return options;
}

nlohmann::ordered_json report_json(const ComponentsArguments& arguments,
                                   const ComponentsResult& result, const Context& context) {
  nlohmann::ordered_json objects = nlohmann::ordered_json::array();
  for (const ComponentRow& row : result.rows) {
    const Box& box = row.box;
    objects.push_back({{"label", row.label},
                       {"voxels", row.voxels},
                       {"mm3", optional_json(row.mm3)},
                       {"centroid_mm", nullptr},
                       {"box",
                        {{box.lo.x, box.hi.x}, {box.lo.y, box.hi.y}, {box.lo.z, box.hi.z}}}});
    if (row.centroid_mm) objects.back()["centroid_mm"] = *row.centroid_mm;
  }
  nlohmann::ordered_json report = {
      {"components", result.found}, {"kept", result.kept}, {"objects", std::move(objects)}};
  if (!arguments.output.empty()) {
    report["output"] = arguments.output;
    report["file_bytes"] = result.file_bytes;
  }
  report["warnings"] = context.warnings;
  return report;
}

std::string table_text(const ComponentsArguments& arguments, const ComponentsResult& result) {
  std::string text =
      fmt::format("{}: {}, {} kept{}\n", public_name(arguments.input),
                  counted_text(static_cast<std::int64_t>(result.found), "component"),
                  count_text(static_cast<std::int64_t>(result.kept)),
                  arguments.output.empty() ? "" : " in " + arguments.output);
  if (!result.rows.empty()) {
    text += fmt::format("{:>7} {:>14} {:>14}  {:<26} {}\n", "label", "voxels", "mm3",
                        result.rows.front().mm3 ? "centroid mm (x, y, z)" : "centroid voxels",
                        "box");
  }
  for (const ComponentRow& row : result.rows) {
    const Point3 center = row.centroid_mm.value_or(row.centroid);
    text += fmt::format("{:>7} {:>14} {:>14}  {:<26} {}:{},{}:{},{}:{}\n", row.label,
                        count_text(static_cast<std::int64_t>(row.voxels)),
                        row.mm3 ? fmt::format("{:.2f}", *row.mm3) : "-",
                        fmt::format("{:.1f}, {:.1f}, {:.1f}", center[0], center[1], center[2]),
                        row.box.lo.x, row.box.hi.x, row.box.lo.y, row.box.hi.y, row.box.lo.z,
                        row.box.hi.z);
  }
  const std::size_t left = result.kept - result.rows.size();
  if (left == 0) return text;
  return text + fmt::format("... {} more; --rows {} shows all\n",
                            count_text(static_cast<std::int64_t>(left)), result.kept);
}

int run_components(const ComponentsArguments& arguments, Context& context) {
  const ComponentsResult result = run_task(components, options_of(arguments, context), context);
  if (context.json) print_json(report_json(arguments, result, context));
  else if (!context.quiet) print(table_text(arguments, result));
  return kExitDone;
}

}  // namespace

void add_components(CLI::App& app, Context& context) {
  const auto arguments = std::make_shared<ComponentsArguments>();
  Verb verb = add_verb(app, context, kComponentsText,
                            [arguments, &context] { return run_components(*arguments, context); });
  verb.add_option("mask", arguments->input, "A label map, .8vo")->type_name("FILE")->required();
  verb.add_option("-o,--output", arguments->output, "The .8vo label map to write")
      ->type_name("FILE");
  verb.add_option("--connectivity", arguments->connectivity,
                  "Voxels are connected by faces (6), edges (18) or corners (26)")
      ->type_name("N")
      ->check(one_of({6, 18, 26}))
      ->capture_default_str();
  verb.add_option("--keep-largest", arguments->keep_largest, "Keep only the N largest")
      ->type_name("N")
      ->check(whole_within(1));
  verb.add_option("--min-mm3", arguments->min_mm3, "Keep only those of this volume or more")
      ->type_name("V")
      ->check(not_negative());
  verb.add_option("--rows", arguments->rows, "Rows of the table, at most")
      ->type_name("N")
      ->check(whole_within(0))
      ->capture_default_str();
}

}  // namespace octavo::cli
