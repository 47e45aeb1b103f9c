// What the readers of meshes share: text in lines of words, and a mesh that grows.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "octavo/mesh/formats/mesh_reader.h"
#include "octavo/mesh/formats/polygon_triangles.h"

namespace octavo {

/// Throws Error{corrupt} that says where: "line 7" or "byte 84".
[[noreturn]] void fail_mesh(const std::string& what, const std::string& where);

/// The axes that a text names, if it does.
std::optional<MeshSpace> space_in(std::string_view text);

/// Lines of a text, and the words of each.
class MeshText {
 public:
  explicit MeshText(std::string_view text) : rest_(text) {}

  /// Goes to the next line; false after the last.
  bool next_line();
  /// The next word of the line; empty behind the last.
  std::string_view word();
  /// Throws Error{corrupt} where the next word is no number.
  double number();
  /// What is left of the line.
  std::string_view line() const { return line_; }
  /// What is left behind the line.
  std::string_view rest() const { return rest_; }
  std::string where() const { return "line " + std::to_string(line_number_); }

 private:
  std::string_view rest_;
  std::string_view line_;
  std::uint64_t line_number_ = 0;
};

/// The number that a word is, nothing else before or behind it.
std::optional<double> number_in_word(std::string_view word);

/// Takes points and polygons in the order of a file.
class MeshGrowth {
 public:
  explicit MeshGrowth(std::uint64_t most_bytes) : most_bytes_(most_bytes) {}

  std::size_t point_count() const { return mesh_.points.size(); }

  /// Throws Error{source_rejected} and Error{limit_exceeded}
  void add_point(double x, double y, double z);
  /// The triangles of polygon_triangles.h; of fewer than three corners nothing.
  /// Requires corners that are points. Throws Error{limit_exceeded}
  void add_polygon(std::span<const std::uint32_t> corners);
  /// Makes points that are equal one.
  void weld();

  /// The mesh. Throws Error{source_rejected} where it has no triangles
  TriangleMesh take();
  /// The mesh, with triangles or without.
  TriangleMesh take_any() { return std::move(mesh_); }

 private:
  void require_room(std::uint64_t bytes) const;

  TriangleMesh mesh_;
  PolygonCutter cutter_;
  std::uint64_t most_bytes_;
};

/// Throws Error{source_rejected} where a mesh has none.
void require_triangles(const TriangleMesh& mesh);

MeshReading read_stl(ByteSpan bytes, std::uint64_t most_bytes);
MeshReading read_ply(ByteSpan bytes, std::uint64_t most_bytes);
MeshReading read_obj(ByteSpan bytes, std::uint64_t most_bytes);

inline std::string_view text_of(ByteSpan bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace octavo
