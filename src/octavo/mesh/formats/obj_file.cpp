#include <cstdint>
#include <string>

#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"

namespace octavo {

namespace {

/// A backslash at the end would join the next line to it.
std::string obj_line(const std::string& text) {
  std::string line = line_text(text);
  if (line.ends_with('\\')) line += ' ';
  return line;
}

/// A name that is one word: groups are told apart by spaces.
std::string group_name(const MeshPart& part) {
  std::string name = obj_line(part_name(part));
  for (char& letter : name) letter = letter == ' ' ? '_' : letter;
  return name;
}

void write_floats(MeshBytes& out, const char* keyword, const MeshPoint& values) {
  out.text(keyword);
  for (const float value : values) {
    out.text(" ");
    out.digits(value);
  }
  out.text("\n");
}

}  // namespace

void write_obj(const MeshDescription& described, PendingFile& file) {
  const TriangleMesh& mesh = described.mesh;
  const bool has_normals = !described.normals.empty();
  MeshBytes out(file);
  for (const std::string& comment : described.comments) {
    out.text("# " + obj_line(comment) + "\n");
  }
  if (!described.report.empty()) out.text("# report " + line_text(described.report) + "\n");
  out.text("# " + space_words(described.space) + "\n");
  for (const MeshPoint& point : mesh.points) {
    write_floats(out, "v", in_space(point, described.space));
  }
  for (const MeshPoint& normal : described.normals) {
    write_floats(out, "vn", in_space(normal, described.space));
  }

  const auto write_face = [&](const MeshTriangle& t) {
    out.text("f");
    for (const std::uint32_t number : t) {
      out.text(" ");
      out.digits(std::uint64_t{number} + 1);
      if (!has_normals) continue;
      out.text("//");
      out.digits(std::uint64_t{number} + 1);
    }
    out.text("\n");
  };
  const MeshPart* part = described.parts.data();
  const MeshPart* const parts_end = part + described.parts.size();
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (; part != parts_end && part->begin <= i; ++part) {
      out.text("g " + group_name(*part) + "\n");
    }
    if (!described.pairs.empty() && (i == 0 || described.pairs[i] != described.pairs[i - 1])) {
      out.text("g label_" + std::to_string(described.pairs[i][0]) + "_to_" +
               std::to_string(described.pairs[i][1]) + "\n");
    }
    write_face(mesh.triangles[i]);
  }
  out.flush();
}

}  // namespace octavo
