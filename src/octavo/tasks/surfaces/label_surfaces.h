// The surfaces of labels: one file of all that lies between them, or a part for each of them that
// fits its neighbors exactly.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/hasher.h"
#include "octavo/core/option_words.h"
#include "octavo/mesh/formats/mesh_file.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/surface.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

enum class LabelSurfaceForm {
  interfaces,  ///< all surfaces, each once, with the labels on both sides
  parts        ///< the closed surface of each label
};

constexpr auto option_words(LabelSurfaceForm) {
  using enum LabelSurfaceForm;
  return std::to_array<NamedValue<LabelSurfaceForm>>(
      {{"parts", parts}, {"interfaces", interfaces}});
}

struct LabelSurfacesOptions {
  std::string input;  ///< an .8vo file of labels or a URL of one
  /// Of interfaces a .ply, .obj or .vtp file. Of parts a file of a format that knows parts, all but
  /// .stl, or else a folder, which gets a file for each.
  Output output;
  LabelSurfaceForm form = LabelSurfaceForm::parts;
  MeshFormat part_format = MeshFormat::stl;  ///< of the files in a folder
  AskedLabels labels;                        ///< these; with none all but 0
  int level = 0;
  int smoothing_steps = 20;  ///< 0: sides of voxels stay as they are
  /// Of surfaces with fewer triangles; lines where three labels meet stay as they are.
  AskedDeviation max_deviation;
  /// Instead of a deviation: the surfaces between labels, each counted once, have as many at most.
  std::optional<AskedTriangles> triangles;
  MeshSpace space = MeshSpace::lps;
};

/// The surface of one label.
struct LabelSurface {
  std::int64_t label = 0;
  std::string path;  ///< of its file in the folder; else empty
  std::uint64_t point_count = 0;
  std::uint64_t triangle_count = 0;
  /// Points at one place are no fault: so far from 0 that they cannot be told apart.
  MeshCheck check;
  std::uint64_t touching_points = 0;  ///< where the label touches itself: they are moved apart
  MeshMeasures measures;        ///< of voxels of 1 mm where the spacing is not known
  std::int64_t voxel_count = 0;
  double volume_change = 0;     ///< against that of its voxels, as a share of it
  double longest_move_mm = 0;   ///< of a point by smoothing

  bool is_sound() const {
    return check.is_closed() && check.is_manifold();
  }
};

struct LabelSurfacesResult {
  VolumeDescription volume;
  Sha256Digest voxel_digest{};
  std::uint64_t point_count = 0;
  std::uint64_t triangle_count = 0;
  std::uint64_t full_triangle_count = 0;  ///< of all surfaces, each once, before there were fewer
  std::uint64_t reduced_triangle_count = 0;  ///< the same behind that
  double max_deviation_mm = 0;               ///< proven, in both directions
  /// Triangles that cross others; nothing where all triangles are kept.
  std::optional<std::uint64_t> crossing_triangles;
  std::uint64_t pair_count = 0;      ///< of labels that lie side by side, 0 among them
  std::vector<LabelSurface> labels;  ///< ascending
  bool is_sound = false;             ///< those of all labels are closed and manifold
  bool is_written = false;           ///< not where they are not
  std::uint64_t file_bytes = 0;
};

/// Writes surfaces between the labels of a level, where the volume ends as well. All files get
/// their names when all are complete. Warns where a volume changes by more than 1 %.
/// Throws  as open_labels, require_free, labels_of, extract_net and write_mesh;
///         Error{invalid_argument} where no voxel has a label, for a label that is not there, for
///         triangles fewer than the surfaces can be made of, for formats that cannot hold what is
///         asked for
/// Memory  130 bytes per triangle of the surfaces, and twice the part that is written; all parts
///         where they go into one file; with a deviation that of decimate_interfaces
LabelSurfacesResult label_surfaces(const LabelSurfacesOptions& options,
                                   const TaskContext& context);

}  // namespace octavo
