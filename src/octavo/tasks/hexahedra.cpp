#include "octavo/tasks/hexahedra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/core/text.h"
#include "octavo/file/storage/pending_file.h"
#include "octavo/mesh/hexahedra/hex_cells.h"
#include "octavo/mesh/hexahedra/hex_file.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/mask/components.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/label_trees.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/volume_facts.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo {

namespace {

[[noreturn]] void reject_hexahedra(const std::string& text, const std::string& path,
                                   const char* field) {
  throw Error(ErrorKind::invalid_argument, text, path).with_field(field);
}

HexFormat asked_format(const HexahedraOptions& options) {
  const std::optional<HexFormat> format = hex_format_of(options.output.path);
  if (!format) {
    reject_hexahedra(std::string("a mesh of hexahedra is written as ") + hex_format_endings(),
                     options.output.path, "hexahedra.output");
  }
  if (*format == HexFormat::gmsh && options.method == HexMethod::octree) {
    reject_hexahedra("Gmsh has no hanging nodes", options.output.path, "hexahedra.method");
  }
  require_free(options.output);
  require_no_input(options.output.path, {options.input, options.grey});
  return *format;
}

void require_number(bool is_right, const char* text) {
  if (!is_right) throw Error(ErrorKind::invalid_argument, text);
}

/// Above 0 and finite as a float, in which moduli are kept.
bool is_modulus(double mpa) {
  return mpa >= static_cast<double>(std::numeric_limits<float>::min()) &&
         mpa <= static_cast<double>(std::numeric_limits<float>::max());
}

void check_materials(const HexahedraOptions& options, HexFormat format) {
  require_number(options.poisson_ratio > -1 && options.poisson_ratio < 0.5,
                 "Poisson's ratio must lie between -1 and 0.5");
  if (options.density && options.grey.empty()) {
    reject_hexahedra("a density needs grey values", options.input, "hexahedra.grey");
  }
  if (options.modulus && !options.density) {
    reject_hexahedra("a modulus needs a density", options.input, "hexahedra.density");
  }
  if (options.density) {
    require_number(std::isfinite(options.density->slope) &&
                       std::isfinite(options.density->intercept),
                   "the line of the density must have numbers");
    if (!options.modulus && format != HexFormat::vtu) {
      reject_hexahedra("only .vtu holds densities without a modulus", options.output.path,
                       "hexahedra.modulus");
    }
  }
  if (!options.modulus) return;
  const ModulusPower& power = *options.modulus;
  require_number(power.factor > 0 && std::isfinite(power.factor) && power.exponent >= 0 &&
                     std::isfinite(power.exponent),
                 "the modulus must have a factor above 0 and an exponent of 0 or more");
  require_number(is_modulus(power.minimum_mpa),
                 "the minimum modulus must lie between 1.2e-38 and 3.4e38 MPa");
  require_number(options.bin_count >= 1 && options.bin_count <= 100000,
                 "the number of bins must be 1 to 100000");
}

/// Opens the volume under the cells; null where there is none.
std::shared_ptr<const FileReader> open_grey_of(const HexahedraOptions& options,
                                               const VolumeDescription& volume,
                                               const TaskContext& context) {
  if (options.grey.empty()) return nullptr;
  std::shared_ptr<const FileReader> grey = open_volume(options.grey, context);
  require_same_grid(volume, options.input, grey->description(), options.grey);
  if (grey->description().kind == VolumeKind::grey) return grey;
  reject_hexahedra("holds labels, not grey values", options.grey, "grey.kind");
}

/// The largest part connected over faces where it is asked for; counts the parts.
std::optional<MaskTree> kept_part(const LabelTree& tree, const HexahedraOptions& options,
                                  const TaskContext& context, HexahedraResult& result) {
  std::vector<std::int64_t> labels(tree.labels().begin(), tree.labels().end());
  std::erase(labels, 0);
  std::optional<MaskTree> kept;
  context.on_threads([&] {
    const MaskTree mask = mask_of(tree, labels);
    const Components parts(mask, Connectivity::faces, context.max_memory_bytes);
    result.part_count = parts.components().size();
    if (!options.keep_largest || result.part_count < 2) return;
    std::vector<bool> keep(parts.components().size(), false);
    keep.front() = true;
    kept = parts.select(keep);
  });
  if (result.part_count > 1 && !options.keep_largest) {
    context.note(fmt::format("{}: {} parts are not connected over faces; solvers need each of "
                             "them held",
                             options.input, result.part_count),
                 "hexahedra.keep_largest");
  }
  return kept;
}

/// Rejects densities that are no finite number although the mean is one, and tells of those
/// below 0.
void check_densities(const CellValues& values, const HexahedraOptions& options,
                     const TaskContext& context) {
  std::uint64_t beyond = 0;
  std::uint64_t below = 0;
  for (std::size_t i = 0; i < values.mean.size(); ++i) {
    const float density = values.density_g_cm3[i];
    if (density < 0) ++below;
    if (std::isfinite(values.mean[i]) && !std::isfinite(density)) ++beyond;
  }
  if (beyond != 0) {
    reject_hexahedra(fmt::format("the density of {} cells is not a finite number", beyond),
                     options.grey, "hexahedra.density_range");
  }
  if (below == 0) return;
  context.warn({fmt::format("{}: {} of {} cells have a density below 0{}", options.grey, below,
                            values.mean.size(),
                            options.modulus ? " and get the modulus of density 0" : ""),
                "hexahedra.density_range"});
}

void check_moduli(const CellValues& values, const HexahedraOptions& options) {
  const auto beyond = std::ranges::count_if(
      values.modulus_mpa, [](float modulus) { return !std::isfinite(modulus); });
  if (beyond == 0) return;
  reject_hexahedra(fmt::format("the modulus of {} cells is not a finite number", beyond),
                   options.grey, "hexahedra.modulus_range");
}

CellValues cell_values_of(const FileReader& grey, const std::vector<HexCell>& cells,
                     const HexahedraOptions& options, const TaskContext& context) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  context.require_memory(cells.size() * (sizeof(HexCell) + 3 * sizeof(float)) +
                             4 * kMiB * static_cast<std::uint64_t>(context.thread_count()),
                         "the hexahedra");
  CellValues values;
  context.on_threads([&] {
    values.mean = cell_means(grey, options.level, cells, context.watcher());
  });
  if (options.density) {
    values.density_g_cm3 = densities_of(values.mean, *options.density);
    check_densities(values, options, context);
  }
  if (!options.modulus) return values;
  const auto unknown = std::count_if(values.mean.begin(), values.mean.end(),
                                     [](float mean) { return !std::isfinite(mean); });
  if (unknown != 0) {
    reject_hexahedra(fmt::format("{} elements have no grey value but NaN or infinities, so no "
                                 "modulus",
                                 unknown),
                     options.grey, "");
  }
  values.modulus_mpa = moduli_of(values.density_g_cm3, *options.modulus);
  check_moduli(values, options);
  return values;
}

/// Bytes that sorting cells into groups takes, or behind that numbering their corners, which lie in
/// blocks of cells and in as many behind them. Requires cells in o-code order.
std::uint64_t bytes_of_mesh(const std::vector<HexCell>& cells) {
  constexpr std::uint64_t kSorted = 2 * sizeof(HexCell) + 6 * sizeof(float) + sizeof(std::uint32_t);
  std::uint64_t blocks = 0;
  GridPoint last{};
  for (const HexCell& cell : cells) {
    const GridPoint block = {cell.corner[0] >> 4, cell.corner[1] >> 4, cell.corner[2] >> 4};
    if (blocks == 0 || block != last) ++blocks;
    last = block;
  }
  return std::max(cells.size() * kSorted,
                  cells.size() * sizeof(HexCell) + 2 * blocks * HexNodes::kBlockBytes);
}

HexMesh mesh_of(const FileReader& reader, const FileReader* grey, HexFormat format,
                const HexahedraOptions& options, const TaskContext& context,
                HexahedraResult& result) {
  const LabelNames& names = reader.description().metadata.facts().labels;
  const std::vector<std::int64_t> asked = labels_of(options.labels, names, options.input);
  const LabelTree tree = read_label_tree(reader, options.level, asked, "label map", context);
  if (std::ranges::all_of(tree.labels(), [](std::int64_t label) { return label == 0; })) {
    reject_hexahedra(fmt::format("is empty: no voxel of level {} has a label{}", options.level,
                                 options.labels.is_empty() ? "" : " that was asked for"),
                     options.input, options.labels.is_empty() ? "" : "labels.numbers");
  }
  std::vector<std::int64_t> missing = asked;
  std::erase_if(missing, [&](std::int64_t label) {
    return std::ranges::find(tree.labels(), label) != tree.labels().end();
  });
  require_no_missing(missing, options.level, names, options.input);
  const std::optional<MaskTree> within = kept_part(tree, options, context, result);
  const std::uint64_t base =
      tree.memory_bytes() + (within ? within->memory_bytes() : std::uint64_t{0});
  const RequireBytes require = [&](std::uint64_t bytes) {
    context.stop_if_cancelled();
    context.require_memory(base + bytes, "the hexahedra");
  };
  std::vector<HexCell> cells;
  context.on_threads([&] {
    cells = hex_cells(tree,
                      {options.method, within ? &*within : nullptr,
                       format == HexFormat::mfem && options.method == HexMethod::octree,
                       &context.watcher()},
                      require);
  });
  CellValues values;
  if (grey != nullptr) values = cell_values_of(*grey, cells, options, context);
  require(bytes_of_mesh(cells));
  std::vector<HexGroup> groups = options.modulus
                                     ? group_by_modulus(cells, values, options.bin_count)
                                     : group_by_label(cells, values);
  std::optional<HexMesh> mesh;
  context.on_threads([&] {
    mesh.emplace(reader.levels().geometry(reader.description().geometry, options.level),
                 options.method,
                 std::vector<std::int64_t>(tree.labels().begin(), tree.labels().end()),
                 std::move(cells), std::move(groups), std::move(values), context.watcher());
  });
  require(mesh->memory_bytes());
  return *std::move(mesh);
}

void count_elements(const HexMesh& mesh, HexahedraResult& result) {
  result.element_count = mesh.element_count();
  result.cell_count = mesh.cells().size();
  result.node_count = mesh.node_count();
  result.hanging_count = mesh.hanging_count();
  for (const HexCell& cell : mesh.cells()) {
    if (result.cells_of_level.size() <= cell.level) result.cells_of_level.resize(cell.level + 1u);
    ++result.cells_of_level[cell.level];
    result.voxel_count += cube_volume(cell.level);
  }
  for (const HexGroup& group : mesh.groups()) {
    for (std::size_t shape = 0; shape < 3; ++shape) {
      result.elements_of_shape[shape] += group.element_counts[shape];
    }
    const std::int64_t label = mesh.labels()[group.label];
    if (result.labels.empty() || result.labels.back() != label) result.labels.push_back(label);
  }
  if (mesh.has_materials()) result.material_count = mesh.groups().size();
  const std::vector<float>& moduli = mesh.values().modulus_mpa;
  if (!moduli.empty()) {
    const auto [lowest, highest] = std::minmax_element(moduli.begin(), moduli.end());
    result.modulus_range_mpa = {static_cast<double>(*lowest), static_cast<double>(*highest)};
  }
  const Point3& spacing = mesh.geometry().spacing_mm;
  result.volume_mm3 =
      static_cast<double>(result.voxel_count) * spacing[0] * spacing[1] * spacing[2];
}

std::vector<std::string> hex_comments(const HexahedraOptions& options, const FileReader& reader) {
  return {"octavo hexahedra of voxels with SHA-256 " + hex_text(reader.voxel_digest()),
          fmt::format("level {}, {}, SPACE=LPS UNIT=mm", options.level,
                      word_of(options.method))};
}

}  // namespace

Facts quality_facts(const HexQuality& quality) {
  const Facts jacobians = {{"min", quality.percentile(0)},
                           {"p1", quality.percentile(1)},
                           {"p5", quality.percentile(5)},
                           {"p50", quality.percentile(50)},
                           {"max", quality.percentile(100)}};
  return {{"scaled_jacobian", jacobians},
          {"min_volume_mm3", quality.min_volume_mm3},
          {"max_volume_mm3", quality.max_volume_mm3},
          {"total_volume_mm3", quality.total_volume_mm3}};
}

HexahedraResult hexahedra(const HexahedraOptions& options, const TaskContext& context) {
  const HexFormat format = asked_format(options);
  check_materials(options, format);
  const std::shared_ptr<const FileReader> reader = open_labels(options.input, context, kAsMask);
  require_level(reader->levels(), options.level);
  const std::shared_ptr<const FileReader> grey =
      open_grey_of(options, reader->description(), context);
  if (!is_spacing_known(reader->description())) {
    context.warn(options.input +
                 ": its spacing is not known; the mesh is written as if voxels were 1 mm");
  }
  HexahedraResult result;
  result.volume = reader->description();
  const HexMesh mesh = mesh_of(*reader, grey.get(), format, options, context, result);
  count_elements(mesh, result);
  if (options.has_quality) result.quality = mesh.quality();

  PendingFile file(local_storage(), options.output.path);
  {
    const ProgressScope scope(context.watcher(), "mesh", 1, "mesh");
    write_hex_mesh(mesh, format, {hex_comments(options, *reader), options.poisson_ratio,
                    reader->description().metadata.facts().labels},
                   context.watcher(), file);
  }
  context.stop_if_cancelled();
  file.seal();
  file.publish(options.output.overwrite);
  result.file_bytes = file.size();
  return result;
}

}  // namespace octavo
