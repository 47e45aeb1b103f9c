#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"

namespace octavo {

namespace {

/// A backslash at the end would join the next line to it, for some readers also before spaces.
std::string obj_line(const std::string& text) {
  std::string line = line_text(text);
  for (char& letter : line) letter = letter == '\\' ? '_' : letter;
  return line;
}

/// A name that is one word: groups are told apart by spaces, and # begins a comment.
std::string object_name(const MeshPart& part) {
  std::string name = obj_line(part_name(part));
  for (char& letter : name) letter = letter == ' ' || letter == '#' ? '_' : letter;
  return name;
}

/// The names of parts, the numbers of their labels behind those that are alike.
std::vector<std::string> object_names(std::span<const MeshPart> parts) {
  std::vector<std::string> names;
  std::map<std::string, int> counts;
  for (const MeshPart& part : parts) {
    names.push_back(object_name(part));
    ++counts[names.back()];
  }
  // Labels may be missing or alike; the places of parts are not.
  bool has_labels_behind = false;
  for (bool is_changed = true; is_changed; has_labels_behind = true) {
    is_changed = false;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      if (counts[names[i]] < 2) continue;
      const bool takes_label = parts[i].label && !has_labels_behind;
      names[i] += "_" + (takes_label ? std::to_string(*parts[i].label) : std::to_string(i + 1));
      ++counts[names[i]];
      is_changed = true;
    }
  }
  return names;
}

void write_floats(MeshBytes& out, const char* keyword, const MeshPoint& values) {
  out.text(keyword);
  for (const float value : values) {
    out.text(" ");
    out.text(coordinate_text(value));
  }
  out.text("\n");
}

}  // namespace

void write_obj(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  const TriangleMesh& mesh = described.mesh;
  const bool has_normals = !described.normals.empty();
  MeshBytes out(file, watcher);
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
  const std::vector<std::string> names = object_names(described.parts);
  std::size_t part = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    for (; part < names.size() && described.parts[part].begin <= i; ++part) {
      out.text("o " + names[part] + "\ng " + names[part] + "\n");
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
