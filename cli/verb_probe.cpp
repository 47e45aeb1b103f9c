// octavo probe: the value, the place and the o-code of single voxels.
#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/tasks/files/probe.h"
#include "octavo/tasks/volume_facts.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kProbeText = {
    "probe", "Show value, place and o-code of a voxel.",
    "Several positions may be given, behind one --at or --mm or each behind its own. Millimeters\n"
    "are LPS world coordinates; the nearest voxel answers.\n\n"
    "Examples:\n"
    "  octavo probe head.8vo --at 128,100,54\n"
    "  octavo probe head.8vo --at 128,100,54 30,40,54\n"
    "  octavo probe head.8vo --mm 12.5,-30,81 --level 2 --json"};

nlohmann::ordered_json probe_json(const ProbedVoxel& p, const VolumeDescription& d) {
  nlohmann::ordered_json name;
  if (d.kind == VolumeKind::labels) {
    name = name_json(d.metadata.facts().labels, static_cast<std::int64_t>(p.stored));
  }
  return {{"index", {p.index.x, p.index.y, p.index.z}},
          {"level", p.code.level},
          {"world_mm", if_in_mm(d, p.world_mm)},
          {"stored", p.stored},
          {"real", d.rescale.to_real(p.stored)},
          {"name", name},
          {"o_code",
           {{"mixed_octal", to_mixed_octal(p.code, p.root_level)},
            {"hierarchical", to_hierarchical(p.code, p.root_level)},
            {"root_level", p.root_level}}},
          {"brick",
           {{"tier", p.brick.tier},
            {"position", {p.brick.brick.x, p.brick.brick.y, p.brick.brick.z}},
            {"code", p.brick.code},
            {"uniform", p.brick.is_uniform()},
            {"min", d.voxel_of(p.brick.range.min)},
            {"max", d.voxel_of(p.brick.range.max)},
            {"max_error", p.brick.max_error}}}};
}

/// The name of the label that a voxel is.
std::string label_suffix(const ProbedVoxel& p, const VolumeDescription& d) {
  if (d.kind != VolumeKind::labels) return "";
  return name_suffix(d.metadata.facts().labels, static_cast<std::int64_t>(p.stored));
}

/// In both notations where they differ: those of a voxel of level 0 have the same digits.
std::string code_text(const ProbedVoxel& p) {
  const std::string code = to_mixed_octal(p.code, p.root_level);
  const std::string digits = to_hierarchical(p.code, p.root_level);
  const std::string second = digits == code ? "" : "hierarchical " + digits + ", ";
  return fmt::format("{} ({}root level {})", code, second, p.root_level);
}

std::string probe_text(const ProbedVoxel& p, const VolumeDescription& d) {
  std::string value = real_text(d, p.stored);
  value += label_suffix(p, d);
  if (!d.rescale.is_identity()) value += fmt::format(" (stored {})", number_text(p.stored));
  const BrickEntry& b = p.brick;
  const std::string place = is_spacing_known(d)
                                ? fmt::format(" at {} mm", point_text(p.world_mm, ", "))
                                : " (spacing not known)";
  return fmt::format(
      "voxel {},{},{} of level {}{}\n"
      "  value   {}\n"
      "  o-code  {}\n"
      "  brick   {},{},{} of tier {}{}, stored values {} to {}{}\n",
      p.index.x, p.index.y, p.index.z, p.code.level, place, value,
      code_text(p),
      b.brick.x, b.brick.y, b.brick.z, b.tier, b.is_uniform() ? ", uniform" : "",
      number_text(d.voxel_of(b.range.min)), number_text(d.voxel_of(b.range.max)),
      b.max_error > 0 ? ", within " + distance_text(d, b.max_error) + " of the source" : "");
}

int run_probe(const ProbeOptions& options, Context& context) {
  if (options.indices.empty() && options.positions_mm.empty()) {
    throw Error(ErrorKind::invalid_argument, "probe needs a position: --at x,y,z or --mm x,y,z");
  }
  const ProbeResult result = probe(options, brief_task(context));
  nlohmann::ordered_json points = nlohmann::ordered_json::array();
  for (const ProbedVoxel& voxel : result.voxels) {
    if (context.json) points.push_back(probe_json(voxel, result.volume));
    else print(probe_text(voxel, result.volume));
  }
  if (context.json) print_json({{"unit", unit_of(result.volume)}, {"points", points}});
  return kExitDone;
}

}  // namespace

void add_probe(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kProbeText, run_probe);
  verb.add_input(options.input);
  verb.add_list("--at INDEX", options.indices, parse_index, "x,y,z in voxels of the level");
  verb.add_list("--mm MM", options.positions_mm, parse_point, "x,y,z in mm");
  add_level(verb, options.level);
}

}  // namespace octavo::cli
