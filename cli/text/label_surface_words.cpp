#include "text/label_surface_words.h"

#include <fmt/format.h>

#include <vector>

#include "common/context.h"
#include "octavo/core/sha256.h"
#include "octavo/tasks/volume_facts.h"
#include "text/label_words.h"
#include "text/quantities.h"
#include "text/table.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

const LabelNames& names_in(const LabelSurfacesResult& result) {
  return result.volume.metadata.facts().labels;
}

std::string faults_text(const LabelSurfacesOptions& options, const LabelSurfacesResult& result) {
  std::string text = shown_path(options.output.path) + ": not written\n";
  bool are_rounded = false;
  for (const LabelSurface& surface : result.labels) {
    if (surface.is_sound()) continue;
    text += fmt::format("label {}{}: {}\n", surface.label,
                        name_suffix(names_in(result), surface.label), fault_words(surface.check));
    are_rounded = are_rounded || surface.check.coincident_points > 0;
  }
  if (are_rounded) {
    text += "coordinates are float32: far from 0 their steps are too long to tell points apart; a\n"
            "volume whose origin is nearer to 0 helps\n";
  }
  return text;
}

std::string touching_text(const LabelSurfacesResult& result) {
  std::size_t count = 0;
  for (const LabelSurface& surface : result.labels) {
    count += surface.touching_points > 0 ? 1u : 0u;
  }
  if (count == 0) return "closed, manifold\n";
  return fmt::format("closed, manifold; {} of {} labels touch themselves at points or edges\n",
                     count, result.labels.size());
}

nlohmann::ordered_json label_json(const LabelSurface& surface, const LabelSurfacesResult& result) {
  const VolumeDescription& volume = result.volume;
  const MeshCheck& check = surface.check;
  return {{"label", surface.label},
          {"name", name_json(names_in(result), surface.label)},
          {"output", text_json(surface.path)},
          {"triangles", surface.triangle_count},
          {"points", surface.point_count},
          {"components", check.components},
          {"closed", check.is_closed()},
          {"manifold", surface.is_sound()},
          {"euler_number", check.euler_number},
          {"open_sides", check.open_sides},
          {"repeated_sides", check.repeated_sides},
          {"pinched_points", check.pinched_points},
          {"coincident_points", check.coincident_points},
          {"touching_points", surface.touching_points},
          {"voxels", surface.voxel_count},
          {"area_mm2", if_in_mm(volume, surface.measures.area_mm2)},
          {"volume_mm3", if_in_mm(volume, surface.measures.volume_mm3)},
          {"volume_change", surface.volume_change},
          {"longest_move_mm", if_in_mm(volume, surface.longest_move_mm)}};
}

}  // namespace

std::string fault_words(const MeshCheck& check) {
  return fmt::format(
      "{} open sides, {} repeated ones, {} points where parts touch, {} points at one place",
      check.open_sides, check.repeated_sides, check.pinched_points, check.coincident_points);
}

std::string label_surfaces_text(const LabelSurfacesOptions& options,
                                const LabelSurfacesResult& result) {
  if (!result.is_written) return faults_text(options, result);
  std::string text =
      fmt::format("{}: {}, {}\n", shown_path(options.output.path),
                  count_of(result.labels.size(), "label"),
                  count_of(result.triangle_count, "triangle"));
  text += touching_text(result);
  if (result.max_deviation_mm > 0) {
    text += fmt::format("{:.3g} % of the triangles between labels, proven within {:.4g} mm; {} "
                        "cross others\n",
                        100 * static_cast<double>(result.reduced_triangle_count) /
                            static_cast<double>(result.full_triangle_count),
                        result.max_deviation_mm, count_of(result.crossing_triangles.value_or(0)));
  }
  std::vector<TextColumn> columns = {
      {"label", 10}, name_column(), {"triangles", 11}, {"voxels", 13}, {"volume %", 10}};
  const bool is_spaced = is_spacing_known(result.volume);
  if (is_spaced) columns.insert(columns.end(), {{"mm3", 13}, {"moved mm", 9}});
  TextTable table(columns);
  for (const LabelSurface& surface : result.labels) {
    table.add({std::to_string(surface.label), names_in(result).name_of(surface.label),
               count_of(surface.triangle_count), count_text(surface.voxel_count),
               fmt::format("{:+.2f}", 100 * surface.volume_change),
               fmt::format("{:.6g}", surface.measures.volume_mm3),
               fmt::format("{:.3g}", surface.longest_move_mm)});
  }
  return text + table.text();
}

nlohmann::ordered_json label_surfaces_json(const LabelSurfacesOptions& options,
                                           const LabelSurfacesResult& result) {
  return {{"output", options.output.path},
          {"is_written", result.is_written},
          {"file_bytes", result.file_bytes},
          {"voxel_digest", hex_text(result.voxel_digest)},
          {"level", options.level},
          {"space", word_of(options.space)},
          {"smoothing_steps", options.smoothing_steps},
          {"triangles", result.triangle_count},
          {"points", result.point_count},
          {"interface_triangles", result.reduced_triangle_count},
          {"full_interface_triangles", result.full_triangle_count},
          {"max_deviation_mm", if_in_mm(result.volume, result.max_deviation_mm)},
          {"self_intersections", json_of(result.crossing_triangles)},
          {"pairs", result.pair_count},
          {"closed_manifold", result.is_sound},
          {"labels", json_list(result.labels, [&](const LabelSurface& surface) {
             return label_json(surface, result);
           })}};
}

}  // namespace octavo::cli
