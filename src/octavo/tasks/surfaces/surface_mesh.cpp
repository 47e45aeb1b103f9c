#include "octavo/tasks/surfaces/surface_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/layered_decimation/layered_decimation.h"
#include "octavo/mesh/surface_piece.h"
#include "octavo/ops/label/missing_labels.h"
#include "octavo/tasks/range_words.h"
#include "octavo/tasks/surfaces/reduced_mesh.h"
#include "octavo/tasks/value_ranges.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

[[noreturn]] void reject_surface(const std::string& text, const std::string& path,
                                 const char* field) {
  throw Error(ErrorKind::invalid_argument, text, path).with_field(field);
}

/// Proves that options and volume go together.
void check_kind(const SurfaceOptions& options, const VolumeDescription& volume) {
  if (volume.kind == VolumeKind::labels) {
    if (options.isovalue) {
      reject_surface("holds labels, which have no isovalue", options.input, "isovalue");
    }
    if (options.is_stored) {
      reject_surface("holds labels, which are no stored values", options.input, "isovalue.stored");
    }
    return;
  }
  if (!options.labels.is_empty()) {
    reject_surface("holds grey values, not labels", options.input, "labels.kind");
  }
  if (!options.isovalue) {
    reject_surface("holds grey values; a surface needs an isovalue", options.input,
                "isovalue.missing");
  }
  if (!std::isfinite(*options.isovalue)) {
    reject_surface("the isovalue is no number", options.input, "");
  }
}

/// Proves by the range of the whole volume that something lies inside.
void check_range(const FileReader& reader, const SurfaceField& field,
                 const SurfaceOptions& options) {
  const VolumeDescription& volume = reader.description();
  const ValueRange range = reader.range();
  const bool may_hold_others = volume.codec_type() == VoxelType::float32;
  const double lowest = volume.voxel_of(range.min);
  const double highest = volume.voxel_of(range.max);
  if (inside_share(field, lowest, highest, may_hold_others) != InsideShare::none) return;
  if (volume.kind == VolumeKind::labels) {
    reject_surface(fmt::format("has no surface: no voxel has {}; its values run from {} to {}",
                            surface_inside_words(options, volume), number_text(lowest),
                            number_text(highest)),
                options.input, "");
  }
  const Rescale rescale = options.is_stored ? Rescale{} : volume.rescale;
  const double smallest = std::min(rescale.to_real(lowest), rescale.to_real(highest));
  const double largest = std::max(rescale.to_real(lowest), rescale.to_real(highest));
  const OutsideWords words = outside_words(*options.isovalue, smallest, largest);
  const std::string unit_name = options.is_stored ? "" : unit_of(volume);
  const std::string unit = unit_name.empty() ? "" : " " + unit_name;
  reject_surface(fmt::format("has no surface: no voxel has {}{} or more; its values run from "
                             "{}{} to {}{}",
                             words.value, unit, words.lowest, unit, words.highest, unit),
                 options.input, "isovalue.range");
}

/// Proves that some voxel has each of the labels that were asked for. Where it is one, the surface
/// tells.
void check_labels(const FileReader& reader, const SurfaceOptions& options,
                  const TaskContext& context) {
  if (options.labels.is_empty()) return;
  const LabelNames& names = reader.description().metadata.facts().labels;
  const std::vector<std::int64_t> labels = labels_of(options.labels, names, options.input);
  if (labels.size() == 1) return;
  std::vector<std::int64_t> missing;
  context.on_threads(
      [&] { missing = missing_labels(reader, options.level, labels, context.watcher()); });
  require_no_missing(missing, options.level, names, options.input);
}

/// The surface within a deviation where it is large, else all of it.
LayeredSurface extracted(const FileReader& reader, const SurfaceField& field,
                         const SurfaceOptions& options, double max_deviation_mm,
                         const TaskContext& context) {
  const Levels& levels = reader.levels();
  const std::int64_t plane_count = levels.size(options.level).z;
  LayeredSurface surface;
  context.on_threads([&] {
    LayeredDecimation decimation(
        {.max_deviation_mm = max_deviation_mm,
         .geometry = levels.geometry(reader.description().geometry, options.level),
         .plane_count = plane_count,
         .max_bytes = context.max_memory_bytes},
        context.watcher());
    const ProgressScope scope(context.watcher(), "surface", plane_count, "planes");
    extract_surface(reader, options.level, field, decimation, context.watcher());
    surface = decimation.take();
  });
  if (surface.is_turned) return extracted(reader, field, options, 0, context);
  if (surface.full_triangle_count > 0) return surface;
  reject_surface(fmt::format("has no surface: no voxel of level {} has {}", options.level,
                          surface_inside_words(options, reader.description())),
              options.input, "");
}

/// The piece that comes nearest to a seed, which lies within a voxel of it.
LayeredSurface piece_at_seed(const FileReader& reader, const SurfaceField& field,
                           const SurfaceOptions& options, const TaskContext& context,
                           SurfaceResult& result) {
  const Point3& seed = *options.seed;
  const Size3 size = reader.levels().size(options.level);
  const std::string place = point_text(seed, ",");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto limit = static_cast<double>(size[static_cast<int>(axis)]);
    if (seed[axis] >= -0.5 && seed[axis] <= limit - 0.5) continue;
    reject_surface(fmt::format("the seed {} lies outside its {} voxels", place, size_text(size)),
                options.input, "seed");
  }
  std::optional<SurfacePiece> piece;
  context.on_threads([&] {
    piece = surface_piece(reader, options.level, field, seed, context.max_memory_bytes,
                          context.watcher());
  });
  if (!piece) {
    reject_surface(fmt::format("no surface passes within a voxel of the seed {}", place),
                options.input, "seed");
  }
  result.decoded_bricks = piece->decoded_bricks;
  const std::uint64_t count = piece->mesh.triangles.size();
  return {.mesh = std::move(piece->mesh), .full_triangle_count = count};
}

/// The smallest and the largest of each coordinate.
std::array<MeshPoint, 2> bounds_of(const TriangleMesh& mesh, MeshSpace space) {
  const MeshPoint first = in_space(mesh.points.front(), space);
  std::array<MeshPoint, 2> bounds = {first, first};
  for (const MeshPoint& point : mesh.points) {
    const MeshPoint place = in_space(point, space);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds[0][axis] = std::min(bounds[0][axis], place[axis]);
      bounds[1][axis] = std::max(bounds[1][axis], place[axis]);
    }
  }
  return bounds;
}

/// Takes triangles away, as far as the options say and extraction has not done.
void reduce(LayeredSurface& surface, const ExtractedReduction& early,
            const SurfaceOptions& options, const Geometry& geometry, bool wants_grid,
            const TaskContext& context, SurfaceMesh& made) {
  if (options.triangles) {
    const std::uint64_t limit =
        triangle_limit(*options.triangles, made.result.full_triangle_count);
    made.grid = reduce_mesh_to(limit, surface, geometry, wants_grid, context, made.result);
  } else if (made.result.max_deviation_mm > 0) {
    made.grid = reduce_mesh(options.method, surface, early, geometry, wants_grid, context,
                            made.result);
  }
}

}  // namespace

std::uint64_t triangle_limit(const AskedTriangles& asked, std::uint64_t full_count) {
  const double amount = asked.amount;
  const bool is_fit = asked.is_percent ? amount > 0 && amount <= 100
                                       : amount >= 1 && amount < 0x1p53 &&
                                             amount == std::floor(amount);
  if (!is_fit) {
    throw Error(ErrorKind::invalid_argument,
                "triangles are a number of 1 or more, or a share above 0 % and up to 100 %");
  }
  if (!asked.is_percent) return static_cast<std::uint64_t>(amount);
  return static_cast<std::uint64_t>(std::floor(static_cast<double>(full_count) * amount / 100));
}

double deviation_mm(const AskedDeviation& asked, const Geometry& geometry) {
  if (!(asked.amount >= 0) || !std::isfinite(asked.amount)) {
    throw Error(ErrorKind::invalid_argument, "the deviation must be a number of 0 or more");
  }
  const auto& [x, y, z] = geometry.spacing_mm;
  return asked.amount * (asked.is_in_voxels ? std::min({x, y, z}) : 1);
}

SurfaceField surface_field_of(const SurfaceOptions& options, const VolumeDescription& volume) {
  if (volume.kind == VolumeKind::labels) {
    return SurfaceField::of_labels(
        labels_of(options.labels, volume.metadata.facts().labels, options.input));
  }
  const ValueWindow window =
      stored_window({*options.isovalue, AskedRange{}.highest}, volume, options.is_stored);
  const bool is_falling = !options.is_stored && volume.rescale.slope < 0;
  return SurfaceField::of_grey(is_falling ? window.highest : window.lowest, is_falling,
                               volume.type);
}

std::string surface_inside_words(const SurfaceOptions& options, const VolumeDescription& volume) {
  if (volume.kind == VolumeKind::labels) {
    return options.labels.is_empty() ? "a label" : "a label that was asked for";
  }
  const std::string unit = options.is_stored ? "" : unit_of(volume);
  return exact_text(*options.isovalue) + (unit.empty() ? "" : " " + unit) + " or more";
}

SurfaceMesh surface_mesh(const FileReader& reader, const SurfaceOptions& options, bool wants_grid,
                         const TaskContext& context) {
  const VolumeDescription& volume = reader.description();
  require_level(reader.levels(), options.level);
  deviation_mm(options.max_deviation, volume.geometry);
  if (options.triangles) triangle_limit(*options.triangles, 1);
  check_kind(options, volume);
  const SurfaceField field = surface_field_of(options, volume);
  check_range(reader, field, options);
  check_labels(reader, options, context);
  if (!is_spacing_known(volume)) {
    context.warn(options.input +
                 ": its spacing is not known; the surface is written as if voxels were 1 mm");
  }

  SurfaceMesh made;
  SurfaceResult& result = made.result;
  const Geometry geometry = reader.levels().geometry(volume.geometry, options.level);
  result.max_deviation_mm = deviation_mm(options.max_deviation, geometry);
  const ExtractedReduction early = reduction_while_extracted(
      options, geometry, reader.levels().size(options.level), wants_grid, result);
  LayeredSurface surface =
      options.seed ? piece_at_seed(reader, field, options, context, result)
                   : extracted(reader, field, options, early.max_deviation_mm, context);
  result.volume = volume;
  result.voxel_digest = reader.voxel_digest();
  result.full_triangle_count = surface.full_triangle_count;
  reduce(surface, early, options, geometry, wants_grid, context, made);
  made.mesh = std::move(surface.mesh);
  result.point_count = made.mesh.points.size();
  result.triangle_count = made.mesh.triangles.size();
  context.on_threads([&] { result.check = check_mesh(made.mesh); });
  result.measures = measure_mesh(made.mesh);
  result.bounds_mm = bounds_of(made.mesh, options.space);
  result.is_sound = result.check.is_closed() && result.check.is_manifold() &&
                    result.crossing_triangles.value_or(0) == 0;
  return made;
}

}  // namespace octavo
