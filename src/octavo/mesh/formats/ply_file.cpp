#include <cstdint>
#include <limits>
#include <string>

#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_file.h"
#include "octavo/mesh/formats/mesh_formats.h"

namespace octavo {

namespace {

std::int32_t ply_label(std::int64_t label, const PendingFile& file) {
  require_label(MeshFormat::ply, label, file.path());
  return static_cast<std::int32_t>(label);
}

std::string ply_header(const MeshDescription& described, bool has_labels) {
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : described.comments) {
    header += short_lines("comment ", comment);
  }
  if (!described.report.empty()) header += short_lines("comment report ", described.report);
  for (const MeshPart& part : described.parts) {
    if (part.label && !part.name.empty()) {
      header += short_lines("comment label " + std::to_string(*part.label) + " ", part.name);
    }
  }
  header += "comment " + space_words(described.space) + "\nelement vertex " +
            std::to_string(described.mesh.points.size()) +
            "\nproperty float x\nproperty float y\nproperty float z\n";
  if (!described.normals.empty()) {
    header += "property float nx\nproperty float ny\nproperty float nz\n";
  }
  header += "element face " + std::to_string(described.mesh.triangles.size()) +
            "\nproperty list uchar int vertex_indices\n";
  if (!described.pairs.empty()) {
    header += "property int inside\nproperty int outside\n";
  } else if (has_labels) {
    header += "property int label\n";
  }
  return header + "end_header\n";
}

}  // namespace

void write_ply(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  const TriangleMesh& mesh = described.mesh;
  require_countable(mesh.points.size(), std::numeric_limits<std::int32_t>::max(), "points", file);
  const bool has_labels = has_part_labels(described);
  MeshBytes out(file, watcher);
  out.text(ply_header(described, has_labels));
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    out.number(in_space(mesh.points[i], described.space));
    if (!described.normals.empty()) out.number(in_space(described.normals[i], described.space));
  }
  const auto* part = described.parts.data();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    out.number(std::uint8_t{3});
    out.number(mesh.triangles[i]);
    if (!described.pairs.empty()) {
      for (const std::int64_t label : described.pairs[i]) out.number(ply_label(label, file));
    } else if (has_labels) {
      while (i >= part->end) ++part;
      out.number(ply_label(*part->label, file));
    }
  }
  out.flush();
}

}  // namespace octavo
