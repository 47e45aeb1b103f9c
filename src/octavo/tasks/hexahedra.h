// A mask or the labels of a map as a mesh of hexahedra for solvers.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/mesh/hexahedra/cell_values.h"
#include "octavo/mesh/hexahedra/hex_mesh.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/result_facts.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(HexMethod) {
  return in_order<HexMethod>("uniform", "octree", "conforming");
}

struct HexahedraOptions {
  std::string input;  ///< a mask or a label map
  Output output;      ///< ends in .vtu, .inp, .msh or .mesh
  HexMethod method = HexMethod::uniform;
  AskedLabels labels;          ///< only these; with none every label but 0
  int level = 0;
  bool keep_largest = false;   ///< only the largest part that is connected over faces
  std::string grey;            ///< measured under the cells, on the same grid; or nothing
  std::optional<DensityLine> density;    ///< needs `grey`, and but for .vtu `modulus`
  std::optional<ModulusPower> modulus;   ///< needs `density`
  double poisson_ratio = 0.3;            ///< of the materials
  int bin_count = 32;                    ///< materials that each label has at most
  bool has_quality = false;              ///< shapes and volumes are measured
};

struct HexahedraResult {
  VolumeDescription volume;  ///< that the mesh was made of
  std::uint64_t element_count = 0;
  std::array<std::uint64_t, 3> elements_of_shape{};  ///< by HexShape
  std::uint64_t cell_count = 0;     ///< cubes, fans as well
  std::uint64_t voxel_count = 0;    ///< in them, of the level
  std::uint64_t node_count = 0;
  std::uint64_t hanging_count = 0;
  std::uint64_t part_count = 0;     ///< connected over faces, before one was kept
  std::vector<std::uint64_t> cells_of_level;  ///< by level of the octree over the voxels
  std::vector<std::int64_t> labels;           ///< of the elements
  std::size_t material_count = 0;
  std::optional<std::array<double, 2>> modulus_range_mpa;
  double volume_mm3 = 0;            ///< of voxels of 1 mm where the spacing is not known
  std::optional<HexQuality> quality;
  std::uint64_t file_bytes = 0;
};

/// The shapes and volumes of the elements.
Facts quality_facts(const HexQuality& quality);

/// Writes a mesh of the voxels of a level. Warns where the spacing is not known, of densities below
/// 0, and of parts that are not connected over faces, which solvers leave afloat.
/// Throws  as open_labels, require_free, labels_of, hex_cells, cell_means and write_hex_mesh;
///         Error{invalid_argument} where no voxel has a label, when options do not go together, for
///         hanging nodes in .msh, where materials are asked for but a cell has no grey value, and
///         where a density or modulus is not finite
/// Memory  that of the label tree; 20 bytes per cell, 1.7 KB per cube of 16^3 voxels that the
///         object meets or touches, with grey values 12 per cell more; 68 bytes per cell while they
///         are sorted
HexahedraResult hexahedra(const HexahedraOptions& options, const TaskContext& context);

}  // namespace octavo
