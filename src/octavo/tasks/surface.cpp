#include "octavo/tasks/surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/core/text.h"
#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/mesh_normals.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/surfaces/surface_file.h"
#include "octavo/tasks/surfaces/surface_mesh.h"
#include "octavo/tasks/surfaces/surface_report.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

[[noreturn]] void reject_mesh(const std::string& text, const std::string& path, const char* field) {
  throw Error(ErrorKind::invalid_argument, text, path).with_field(field);
}

/// The same for all names of a file that may not be there yet.
std::filesystem::path place_of_file(const std::string& path) {
  std::error_code none;
  const std::filesystem::path whole = std::filesystem::absolute(path, none);
  return std::filesystem::weakly_canonical(whole.parent_path(), none) / whole.filename();
}

MeshFormat format_of(const SurfaceOptions& options) {
  const std::optional<MeshFormat> format = mesh_format_of(options.output.path);
  if (!format) {
    reject_mesh(std::string("a surface is written as ") + mesh_format_endings(),
                options.output.path, "surface.output");
  }
  if (*format == MeshFormat::glb && options.space != MeshSpace::lps) {
    reject_mesh("has axes of its own, which every reader knows", options.output.path,
                "surface.space");
  }
  if (*format != MeshFormat::glb && options.is_plain) {
    reject_mesh("is never compressed, as .glb files are", options.output.path, "surface.plain");
  }
  for (const std::string& path : {options.output.path, options.report_path}) {
    if (path.empty()) continue;
    require_free({path, options.output.overwrite});
    require_no_input(path, {options.input});
  }
  if (!options.report_path.empty() &&
      place_of_file(options.report_path) == place_of_file(options.output.path)) {
    reject_mesh("is the surface itself; name another report", options.report_path, "");
  }
  return *format;
}

/// The whole mesh as one object: a label that was asked for, or what lies inside.
MeshPart object_of(const SurfaceOptions& options, const VolumeDescription& volume,
                   const TriangleMesh& mesh) {
  MeshPart object{.name = surface_inside_words(options, volume),
                  .begin = 0,
                  .end = mesh.triangles.size()};
  if (volume.kind != VolumeKind::labels) return object;
  const LabelNames& names = volume.metadata.facts().labels;
  const std::vector<std::int64_t> labels = labels_of(options.labels, names, options.input);
  if (labels.size() != 1) return object;
  object.label = labels.front();
  object.name = names.text_of(*object.label);
  if (names.all().contains(*object.label)) object.color = names.all().at(*object.label).color;
  return object;
}

std::vector<std::string> comments_of(const SurfaceOptions& options, const FileReader& reader) {
  std::vector<std::string> comments = {
      "octavo surface of voxels with SHA-256 " + hex_text(reader.voxel_digest()),
      fmt::format("level {}, inside: {}", options.level,
                  surface_inside_words(options, reader.description()))};
  return comments;
}

}  // namespace

SurfaceResult surface(const SurfaceOptions& options, const TaskContext& context) {
  const MeshFormat format = format_of(options);
  const std::shared_ptr<const FileReader> reader = open_volume(options.input, context);
  const VolumeDescription& volume = reader->description();
  if (volume.kind == VolumeKind::labels && !options.labels.is_empty()) {
    const LabelNames& names = volume.metadata.facts().labels;
    const std::vector<std::int64_t> labels = labels_of(options.labels, names, options.input);
    if (labels.size() == 1) require_label(format, labels.front(), options.output.path);
  }
  const bool wants_grid = format == MeshFormat::glb && !options.is_plain;
  auto [mesh, result, grid] = surface_mesh(*reader, options, wants_grid, context);
  if (!result.is_sound && !options.allows_faults) return result;

  std::vector<MeshPoint> normals;
  if (has_normals(format)) {
    const SurfaceField field = surface_field_of(options, volume);
    context.on_threads([&] {
      normals = gradient_normals(mesh, *reader, options.level, field, context.watcher());
    });
  }
  const std::vector<std::string> comments = comments_of(options, *reader);
  const MeshPart object = object_of(options, volume, mesh);
  const MeshDescription described{.mesh = mesh,
                                  .normals = normals,
                                  .parts = {&object, 1},
                                  .comments = comments,
                                  .report = surface_report(options, result).text(),
                                  .space = options.space,
                                  .grid = grid,
                                  .is_plain = options.is_plain};
  result.file_bytes =
      write_surface(described, format, options.output, options.report_path, context);
  result.is_written = true;
  return result;
}

}  // namespace octavo
