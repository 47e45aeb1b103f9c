// The surface of what lies inside, as a file of triangles.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/hasher.h"
#include "octavo/core/option_words.h"
#include "octavo/mesh/decimation.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/formats/mesh_file.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(MeshSpace) { return in_order<MeshSpace>("lps", "ras"); }

constexpr auto option_words(DecimationMethod) {
  return in_order<DecimationMethod>("collapse", "octree");
}

constexpr auto option_words(MeshFormat) {
  return in_order<MeshFormat>("stl", "ply", "obj", "glb", "vtp", "3mf");
}

/// How far a surface with fewer triangles may lie from the full one, and the full one from it.
struct AskedDeviation {
  double amount = 0;        ///< 0: all triangles are kept
  bool is_in_voxels = true;  ///< of the shortest side of a voxel of the level; else mm
};

/// How many triangles a surface may have at most.
struct AskedTriangles {
  double amount = 0;
  bool is_percent = false;  ///< of the full surface
};

/// Of a full surface with so many, rounded down.
/// Throws Error{invalid_argument} unless it is a whole number of 1 or more, or a share above 0 %
/// and up to 100 %
std::uint64_t triangle_limit(const AskedTriangles& asked, std::uint64_t full_count);

/// In mm, of voxels of a geometry.
/// Throws Error{invalid_argument} unless it is a number of 0 or more
double deviation_mm(const AskedDeviation& asked, const Geometry& geometry);

struct SurfaceOptions {
  std::string input;  ///< an .8vo file or a URL of one
  Output output;      ///< ends in .stl, .ply, .obj, .glb, .vtp or .3mf
  std::string report_path;  ///< of a file of JSON beside it; empty: none
  /// Of grey values, in real units: what is at or above it lies inside.
  std::optional<double> isovalue;
  bool is_stored = false;  ///< the isovalue is a stored value instead of a real one
  AskedLabels labels;      ///< of a label map these; with none every voxel but 0
  int level = 0;
  /// Only the piece of the surface that comes nearest to this place, in voxels of the level. Bricks
  /// that it does not pass are not decoded.
  std::optional<Point3> seed;
  AskedDeviation max_deviation;
  /// Instead of a deviation: the surface has as many triangles at most, and how far it lies is
  /// proven.
  std::optional<AskedTriangles> triangles;
  DecimationMethod method = DecimationMethod::collapse;  ///< with a deviation
  MeshSpace space = MeshSpace::lps;
  bool is_plain = false;  ///< a .glb file without compression, for programs that know none
  bool allows_faults = false;  ///< a surface that is not closed or not manifold is written as well
};

struct SurfaceResult {
  VolumeDescription volume;  ///< that the surface was taken from
  Sha256Digest voxel_digest{};
  std::uint64_t point_count = 0;
  std::uint64_t triangle_count = 0;
  std::uint64_t full_triangle_count = 0;  ///< before there were fewer
  double max_deviation_mm = 0;            ///< proven, in both directions
  /// Triangles that cross others; nothing where all triangles are kept, which cross nowhere.
  std::optional<std::uint64_t> crossing_triangles;
  MeshCheck check;
  MeshMeasures measures;         ///< of voxels of 1 mm where the spacing is not known
  std::array<MeshPoint, 2> bounds_mm{};  ///< in the space that was asked for
  bool is_sound = false;         ///< closed, manifold, and no triangle crosses another
  bool is_written = false;       ///< not where the check found faults that are not allowed
  std::uint64_t file_bytes = 0;
  /// That the piece of a seed passes; nothing without one.
  std::optional<std::uint64_t> decoded_bricks;
};

/// Writes the surface of a level: closed, also where the volume ends, triangles outward; in formats
/// that have normals those of the grey values at the points that are written.
/// Throws  as open_volume, require_free, labels_of, extract_surface and write_mesh;
///         Error{invalid_argument} where no voxel lies inside, for a seed that no surface
///         passes within a voxel, for triangles fewer than the surface can be made of, when
///         options do not go together or with the volume
/// Memory  that of extract_surface or surface_piece, 36 bytes per triangle of the surface, and as
///         much again while it is checked; with fewer triangles that of LayeredDecimation, but with
///         a seed or merged cells that of decimate
SurfaceResult surface(const SurfaceOptions& options, const TaskContext& context);

}  // namespace octavo
