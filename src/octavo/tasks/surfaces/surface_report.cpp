#include "octavo/tasks/surfaces/surface_report.h"

#include <array>

#include "octavo/core/sha256.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

template <class T>
std::string json_or_null(const std::optional<T>& value) {
  return value ? json_text(*value) : "null";
}

}  // namespace

JsonObject surface_report(const SurfaceOptions& options, const SurfaceResult& result) {
  const bool is_spaced = is_spacing_known(result.volume);
  const auto in_mm = [&](const auto& value) { return is_spaced ? json_text(value) : "null"; };
  const MeshCheck& check = result.check;
  JsonObject report;
  report.set("voxel_digest", hex_text(result.voxel_digest))
      .set_json("isovalue", json_or_null(options.isovalue));
  if (options.isovalue && options.is_stored) report.set("is_stored", true);
  if (!options.labels.numbers.empty()) report.set("labels", options.labels.numbers);
  if (!options.labels.names.empty()) report.set("label_names", options.labels.names);
  report.set("level", options.level)
      .set("space", word_of(options.space))
      .set("triangles", result.triangle_count)
      .set("full_triangles", result.full_triangle_count)
      .set("points", result.point_count)
      .set("components", check.components)
      .set("closed", check.is_closed())
      .set("manifold", check.is_manifold())
      .set_json("self_intersections", json_or_null(result.crossing_triangles))
      .set_json("max_deviation_mm", in_mm(result.max_deviation_mm))
      .set("euler_number", check.euler_number)
      .set("open_sides", check.open_sides)
      .set("repeated_sides", check.repeated_sides)
      .set("pinched_points", check.pinched_points)
      .set("coincident_points", check.coincident_points)
      .set_json("area_mm2", in_mm(result.measures.area_mm2))
      .set_json("volume_mm3", in_mm(result.measures.volume_mm3))
      .set_json("bounds_mm", in_mm(result.bounds_mm));
  return report;
}

}  // namespace octavo
