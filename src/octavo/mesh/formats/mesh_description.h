// What a file says of a mesh: its triangles, and what is known of them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "octavo/core/label_names.h"
#include "octavo/core/triangle_mesh.h"
#include "octavo/mesh/formats/point_grid.h"

namespace octavo {

/// Axes of the coordinates that are written. DICOM, ITK and Octavo have x to the left and y to the
/// back; FreeSurfer, NIfTI and the MNI space have both turned round.
enum class MeshSpace { lps, ras };

/// The labels that a triangle parts: inside, outside.
using LabelPair = std::array<std::int64_t, 2>;

/// Triangles that are an object of their own: [begin, end).
struct MeshPart {
  std::string name = {};  ///< UTF-8; may come from any file
  std::optional<std::int64_t> label = {};
  std::optional<LabelColor> color = {};
  std::size_t begin = 0;
  std::size_t end = 0;
};

/// Views, which must outlive the description.
struct MeshDescription {
  const TriangleMesh& mesh;
  std::span<const MeshPoint> normals = {};    ///< empty, or one of length 1 per point, outward
  std::span<const LabelPair> pairs = {};      ///< empty, or one per triangle
  std::span<const MeshPart> parts = {};       ///< empty, or all triangles in their order
  std::span<const std::string> comments = {};  ///< lines for people
  std::string report = {};                    ///< JSON for programs; empty: none
  MeshSpace space = MeshSpace::lps;
  /// Points all lie on it; GLB writes 16 bits a coordinate then.
  std::optional<PointGrid> grid = {};
  bool is_plain = false;  ///< GLB without compression and without extensions
};

}  // namespace octavo
