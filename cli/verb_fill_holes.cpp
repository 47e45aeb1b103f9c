// octavo fill-holes: background that is enclosed by an object becomes part of it.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <optional>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "common/volume_options.h"
#include "octavo/core/text.h"
#include "octavo/tasks/fill_holes.h"
#include "octavo/tasks/volume_facts.h"
#include "text/fact_json.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kFillHolesText = {
    "fill-holes", "Fill the holes of a mask.",
    "A hole is a part of the background that does not reach the border of the volume.\n"
    "--connectivity is that of the object; the background is connected the other way: with 26\n"
    "(the default) or 18 the background is joined by faces alone, so that a wall closed up to its\n"
    "edges holds it, as in scipy and fslmaths; with 6 it passes through edges and corners as\n"
    "well, so that fewer holes are found.\n\n"
    "Examples:\n"
    "  octavo fill-holes skull.8vo -o solid.8vo\n"
    "  octavo fill-holes bone.8vo --max-mm3 5 -o bone-closed.8vo\n"
    "  octavo fill-holes shell.8vo --connectivity 6 -o filled.8vo --json"};

std::string holes_text(const FillHolesResult& result) {
  const std::string left =
      result.larger_hole_count == 0
          ? ""
          : fmt::format("; {} larger left", count_of(result.larger_hole_count));
  if (result.hole_count == 0) return "no holes filled" + left;
  return fmt::format("{} filled ({}){}", count_of(result.hole_count, "hole"),
                     volume_text(result.hole_voxels, result.volume), left);
}

int run_fill_holes(const FillHolesOptions& options, Context& context) {
  const FillHolesResult result = run_task(fill_holes, options, context);
  print_result(context,
               {{"output", options.output.path},
                {"operation", "fill-holes"},
                {"voxels", result.voxels},
                {"mm3", json_of(mm3_of(result.voxels, result.volume))},
                {"holes", result.hole_count},
                {"hole_voxels", result.hole_voxels},
                {"hole_mm3", json_of(mm3_of(result.hole_voxels, result.volume))},
                {"larger_holes", result.larger_hole_count},
                {"file_bytes", result.file_bytes}},
               fmt::format("{}: {}; {}\n", shown_path(options.output.path),
                           volume_text(result.voxels, result.volume), holes_text(result)));
  return kExitDone;
}

}  // namespace

void add_fill_holes(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kFillHolesText, run_fill_holes);
  add_mask_input(verb, options.input);
  verb.add_output(options.output, "The .8vo mask to write");
  add_connectivity(verb, options.connectivity,
                   "The object is joined by faces (6), edges (18) or corners (26)");
  verb.add_option("--max-mm3 V", options.max_mm3, "Fill only holes of this volume or less")
      .check(not_negative());
}

}  // namespace octavo::cli
