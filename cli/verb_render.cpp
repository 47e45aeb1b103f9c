// octavo render: pictures of what an octree holds, seen from a side.
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "common/failure.h"
#include "common/options.h"
#include "common/render_options.h"
#include "common/task_run.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/volume_facts.h"
#include "text/quantities.h"
#include "text/value_range_words.h"
#include "text/volume_json.h"
#include "verbs.h"

namespace octavo::cli {

namespace {

constexpr VerbText kRenderText = {
    "render", "Draw what a volume holds, seen from a side, as a PNG picture.",
    "Modes: cubes draws every leaf of a mask as a cube with three shades, back to front; surface\n"
    "draws those alone that are not hidden among others, the nearest first, and shades them\n"
    "smoothly, by the gradient of grey values or of the mask. --shade flat or smooth goes with\n"
    "both. Both are fitted to what is drawn. transparency lets what lies inside a grey volume\n"
    "shine through what lies around it, summed or averaged along the lines of voxels that are\n"
    "nearest to the view: one of 26 directions.\n\n"
    "Rays see grey values from any side: volume by colors and opacities of --transfer, in light;\n"
    "mip and minip the highest and the lowest value along each ray (the lowest is that of air\n"
    "around a body unless --mask or --cut leaves it out), mean their mean, iso the surface at\n"
    "--isovalue. --transfer is bone, skin, vessels, lung (all in HU), mr, lightsheet\n"
    "or a JSON file: {\"points\": [{\"value\": 150, \"color\": \"#d6a880\",\n"
    "\"opacity\": 0}, ...]}, with \"layer_mm\" the thickness that has these opacities (default:\n"
    "the finest spacing), \"relative\": true where 0 to 1 span the values and \"gradient\":\n"
    "[LOW, HIGH] the values per mm at which opacity begins and is whole. Without --level\n"
    "the picture is of the coarsest level whose voxels are no longer than a pixel; bricks that no\n"
    "ray comes to are not decoded.\n\n"
    "A label map has one color per label; --label and --range choose labels. A grey volume needs\n"
    "--range or --tissue (air, lung, fat, soft, contrast, bone, as in octavo threshold); several\n"
    "are several colors; where they overlap tissues go before ranges, then the one named first. A\n"
    "range may have a color, LOW:HIGH=COLOR, and for transparency the opacity of a layer as\n"
    "thick as the finest spacing, LOW:HIGH=COLOR:OPACITY. Transparency without a range draws a\n"
    "volume in HU as flesh and bone, another one in grey: sums of real values times mm.\n\n"
    "--direction says where the viewer stands: front, back, left, right, top, bottom of the\n"
    "patient, joined as in left-front-top; or X,Y,Z in voxels along the axes of the grid.\n"
    "--azimuth 0 is the front, 90 the patient's left; --elevation 90 is above the head.\n"
    "Letters name the patient's sides at the edges or at the ends of three axes; where nothing is\n"
    "known of a patient the axes are x, y and z of the grid.\n"
    "--cut 'x<120' keeps the voxels below 120, 'x>120' those above; --cut 0:120,0:90,60:108 cuts\n"
    "a box out. --turntable 36 writes NAME-000.png to NAME-035.png, once around the patient, or\n"
    "one animation where the name ends in .apng, .webp or, by ffmpeg where it is there, .mp4;\n"
    "--grow has it grow plane by plane.\n\n"
    "Among rays --mesh draws surfaces of STL, PLY or OBJ files, FILE=COLOR:OPACITY, and --mark a\n"
    "place in mm with a name, X,Y,Z=NAME. --ambient-shade darkens hollows, --shadows throws those\n"
    "of what lies nearer to the lamp: of voxels by a coarse level, of surfaces with hard edges.\n"
    "--time-budget draws coarse levels first and keeps the finest that is complete in time,\n"
    "--progressive writes each.\n"
    "--mask lets rays see the voxels of a mask alone. --labels shows the labels of a label map in\n"
    "their colors, --label-look in another: LABEL=COLOR:OPACITY, LABEL=TRANSFER, LABEL=none, or\n"
    "LABEL=same as the whole; LABEL other is all that is no label or was not chosen by --label.\n"
    "--adaptive casts one ray for 2 x 2 pixels where these hardly differ, --smooth-edges four for\n"
    "one that differs much from its neighbors.\n\n"
    "Examples:\n"
    "  octavo render head.8vo --mode surface --tissue bone -o skull.png\n"
    "  octavo render skull.8vo --mode cubes --azimuth 30 --elevation 20 -o cubes.png\n"
    "  octavo render head.8vo --range -300:225=orange --range 226:=sand --cut 'x<128' -o half.png\n"
    "  octavo render atlas.8vo --direction left --size 800x600 --background white -o atlas.png\n"
    "  octavo render organs.8vo --mode surface --label liver --label 7 -o liver.png\n"
    "  octavo render head.8vo --mode transparency --direction front -o head.png\n"
    "  octavo render head.8vo --mode volume --transfer skin --azimuth 30 -o head.png\n"
    "  octavo render head.8vo --mode iso --isovalue 226 --perspective 30 -o skull.png\n"
    "  octavo render head.8vo --mode mip --direction left -o mip.png\n"
    "  octavo render head.8vo --mode volume --mesh implant.ply=steel:0.6 --shadows -o implant.png\n"
    "  octavo render trunk.8vo --mode volume --labels organs.8vo --label-look other=bone -o o.png\n"
    "  octavo render head.8vo --mode volume --turntable 24 --grow --size 400 -o growth.apng\n"
    "  octavo render rock.8vo --mode transparency --range 90:120=sand:0.01 --range 200:=red:0.2 "
    "-o ores.png"};

nlohmann::ordered_json cube_counts_json(const RenderCounts& counts) {
  nlohmann::ordered_json json = {{"masks", counts.masks},
                                 {"leaves", counts.leaves},
                                 {"drawn", counts.drawn},
                                 {"removed", counts.leaves - counts.drawn}};
  if (counts.shell_seconds) json["shell_seconds"] = *counts.shell_seconds;
  return json;
}

nlohmann::ordered_json line_counts_json(const RenderCounts& counts, bool is_average) {
  const auto range_json = [](const DensityRange& range) -> nlohmann::ordered_json {
    return {{"low", range_end_json(range.lowest)},
            {"high", range_end_json(range.highest)},
            {"color", range.color},
            {"opacity", range.opacity}};
  };
  nlohmann::ordered_json ramp = nullptr;
  if (counts.ramp) ramp = {counts.ramp->low, counts.ramp->high};
  return {{"leaves", counts.leaves},
          {"decoded_bricks", counts.decoded_bricks},
          {"average", is_average},
          {"ranges", json_list(counts.ranges, range_json)},
          {"ramp", ramp},
          {"window", window_json(counts.window)}};
}

nlohmann::ordered_json ray_counts_json(const RenderOptions& options, const RenderResult& result) {
  const RenderCounts& counts = result.counts;
  nlohmann::ordered_json json = {{"samples", counts.rays.samples},
                                 {"bricks_decoded", counts.decoded_bricks},
                                 {"frame_seconds", counts.rays.frame_seconds},
                                 {"first_seconds", result.first_seconds},
                                 {"window", window_json(counts.window)},
                                 {"isovalue", json_of(options.isovalue)}};
  if (!result.passes.empty()) {
    json["is_complete"] = result.is_complete;
    json["passes"] = json_list(result.passes, [](const RenderPass& pass) -> nlohmann::ordered_json {
      return {{"level", pass.level}, {"shrink", pass.shrink}, {"seconds", pass.seconds}};
    });
  }
  return json;
}

nlohmann::ordered_json report_json(const RenderOptions& options, const RenderResult& result) {
  nlohmann::ordered_json json = {
      {"outputs", result.outputs}, {"mode", word_of(options.mode)},
      {"level", result.level},     {"size", {result.width, result.height}},
      {"pixel_mm", if_in_mm(result.volume, result.pixel_mm)},
      {"toward", result.toward}};
  if (is_of_rays(options.mode)) {
    json.update(ray_counts_json(options, result));
  } else if (options.mode == RenderMode::transparency) {
    json.update(line_counts_json(result.counts, options.is_average));
  } else {
    json["shade"] = result.shade == RenderShade::flat ? "flat" : "smooth";
    json.update(cube_counts_json(result.counts));
  }
  json["seconds"] = result.seconds;
  return json;
}

std::string counts_text(RenderMode mode, const RenderResult& result) {
  const RenderCounts& counts = result.counts;
  if (is_of_rays(mode)) {
    return fmt::format("level {}, {}, {} decoded", result.level,
                       counted_text(counts.rays.samples, "sample"),
                       counted_text(counts.decoded_bricks, "brick"));
  }
  const std::string leaves = counted_text(counts.leaves, "leaf", "leaves");
  if (mode == RenderMode::cubes) return leaves;
  if (mode == RenderMode::transparency) {
    const std::string text =
        leaves + ", " + counted_text(counts.decoded_bricks, "brick") + " decoded";
    if (!counts.window) return text;
    const std::string above =
        counts.ramp ? " of sums above " + number_text(counts.ramp->low) : std::string();
    return text + fmt::format(", window {},{}{}", number_text(counts.window->center),
                              number_text(counts.window->width), above);
  }
  const std::int64_t removed = counts.leaves - counts.drawn;
  const double share =
      counts.leaves == 0 ? 0
                         : 100 * static_cast<double>(removed) / static_cast<double>(counts.leaves);
  return fmt::format("{} of {} leaves, {} hidden ones removed ({:.1f} %)", count_text(counts.drawn),
                     count_text(counts.leaves), count_text(removed), share);
}

std::string report_text(const RenderOptions& options, const RenderResult& result) {
  const std::vector<std::string>& paths = result.outputs;
  const std::string names =
      paths.size() == 1 ? shown_path(paths.front())
                        : fmt::format("{} to {}", shown_path(paths.front()),
                                      shown_path(paths.back()));
  const std::string pixel =
      is_spacing_known(result.volume) ? fmt::format(" of {} mm", number_text(result.pixel_mm)) : "";
  return fmt::format("{}: {} x {} pixels{}, {}; drawn in {}\n", names, result.width, result.height,
                     pixel, counts_text(options.mode, result), duration_text(result.seconds));
}

int run_render(const RenderOptions& options, Context& context) {
  const RenderResult result = run_task(render, options, context);
  print_result(context, report_json(options, result), report_text(options, result));
  return kExitDone;
}

}  // namespace

void add_render(CLI::App& app, Context& context) {
  auto [verb, options] = add_verb(app, context, kRenderText, run_render);
  add_render_options(verb, options);
}

}  // namespace octavo::cli
