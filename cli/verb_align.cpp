// octavo align: the pose that lays the surface of one mask onto that of another.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <string>

#include "common/failure.h"
#include "common/options.h"
#include "common/task_run.h"
#include "octavo/core/url_text.h"
#include "octavo/tasks/structure/align.h"
#include "text/fact_json.h"
#include "text/quantities.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kAlignText = {
    "align", "Find the rigid pose that lays a surface onto that of a mask.",
    "The first one moves, the second, a mask, stays. What moves is a mask, a mesh (.stl, .ply,\n"
    ".obj), points (.ply, or .csv with x,y,z in mm, LPS, a row) or lines of sight: a .csv of six\n"
    "numbers a row, of two places on a line each, such as the source of X-rays and a point of\n"
    "the outline of a shadow. Each line is laid so that it touches the surface; they have to come\n"
    "from two sides or more. Nothing has to be near: turns of all kinds are\n"
    "tried. Half of a surface may be missing on either side. The matrix, mm and LPS, is what\n"
    "'octavo transform --affine' takes. With --scale the size is found as well.\n\n"
    "Surfaces agree where they are within a voxel of the coarser mask and face the same way: 30 %\n"
    "of the first have to, and 60 % of what the second has around those, or 50 % where the pose\n"
    "is sharp: of what comes within four voxels 75 % has to be within half of one (its sharpness;\n"
    "from 85 % on it is sharp, below a warning says that the pose is doubtful), and what each has\n"
    "for itself has to lie behind a cut, not all around; where both have any, 75 % has to agree\n"
    "around and 85 % to be sharp.\n"
    "Otherwise there is no pose: the exit code is 1, and no matrix is written. Of meshes and\n"
    "points the sides do not count, and sharpness may be 10 % less; of lines of sight 80 % have\n"
    "to touch within a voxel (below 90 % a warning), and no more is asked. Fewer than 30 points\n"
    "or lines are not taken. docs/poses.md says what was measured of true and false poses, and\n"
    "which of them nothing tells apart.\n\n"
    "The condition says how evenly surfaces hold the pose: 4 to 25 for bodies of all kinds, above\n"
    "90 for balls, rods and rings, which turn or slide in place.\n\n"
    "Examples:\n"
    "  octavo align skull-a.8vo skull-b.8vo -o pose.txt\n"
    "  octavo align probe.stl skull.8vo -o pose.txt --picture pose.png\n"
    "  octavo transform a.8vo --affine pose.txt --grid-of b.8vo -o a-on-b.8vo"};

nlohmann::ordered_json report_json(const AlignOptions& options, const AlignResult& result) {
  nlohmann::ordered_json report = {{"moving", public_name(options.moving)},
                                   {"fixed", public_name(options.fixed)}};
  report.update(json_of(pose_facts(result)));
  return report;
}

std::string report_text(const AlignOptions& options, const AlignResult& result) {
  const FoundPose& pose = result.pose;
  if (!result.is_found) {
    return fmt::format("{} and {}: no pose; {}\n", shown_path(options.moving),
                       shown_path(options.fixed), result.why_none);
  }
  std::string text;
  for (std::size_t row = 0; row < 3; ++row) {
    text += fmt::format("{:>12.6f} {:>12.6f} {:>12.6f} {:>12.4f}\n", pose.map.linear[3 * row],
                        pose.map.linear[3 * row + 1], pose.map.linear[3 * row + 2],
                        pose.map.offset[row]);
  }
  text += fmt::format("{:.0f} % of the surface within two voxels: mean {:.3g} mm, 95 % within "
                      "{:.3g} mm, largest {:.3g} mm\n",
                      100 * pose.overlap, pose.mean_mm, pose.p95_mm, pose.max_mm);
  text += fmt::format("{:.0f} % agree, and {:.0f} % of the second around them; sharpness {:.2f}\n",
                      100 * result.agreement.forward, 100 * result.agreement.backward,
                      result.agreement.sharpness);
  return text + fmt::format("scale {:.6g}, {} iterations, condition {:.3g}\n", pose.scale,
                            pose.iterations, pose.condition);
}

int run_align(const AlignOptions& options, Context& context) {
  const AlignResult result = run_task(align, options, context);
  print_result(context, report_json(options, result), report_text(options, result));
  return result.is_found ? kExitDone : kExitDifferent;
}

}  // namespace

void add_align(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kAlignText, run_align);
  verb.add_option("moving FILE", options.moving, "What moves: .8vo, .stl, .ply, .obj or .csv")
      .required();
  verb.add_option("fixed FILE", options.fixed, "The mask that stays, .8vo").required();
  verb.add_output_option("-o,--output FILE", options.matrix, "A text file for the matrix");
  verb.add_output_option("--picture FILE", options.picture,
                         "A PNG of both: the mask's shadow from three sides, what moved on it");
  verb.add_flag("--scale", options.has_scale, "Find the size as well: a similarity");
}

}  // namespace octavo::cli
