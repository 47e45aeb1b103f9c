#include <cstring>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/mesh/formats/mesh_readers.h"

namespace octavo {

namespace {

constexpr std::size_t kStlHead = 84;  // 80 bytes of text, and the number of triangles
constexpr std::size_t kStlTriangle = 50;

template <class T>
T stl_number(ByteSpan bytes, std::size_t at) {
  T number{};
  std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

void add_loop(std::vector<std::uint32_t>& corners, MeshGrowth& mesh, const std::string& where) {
  if (corners.size() < 3) fail_mesh("a loop of fewer than three corners", where);
  mesh.add_polygon(corners);
  corners.clear();
}

MeshReading read_text_stl(ByteSpan bytes, std::uint64_t most_bytes) {
  MeshText text(text_of(bytes));
  MeshGrowth mesh(most_bytes);
  MeshReading reading;
  std::vector<std::uint32_t> corners;
  while (text.next_line()) {
    const std::string_view line = text.line();
    const std::string_view word = text.word();
    if (word == "solid" || word == "endsolid") {
      // What follows is a name.
      if (!reading.space) reading.space = space_in(line);
    } else if (word == "vertex") {
      const double x = text.number();
      const double y = text.number();
      mesh.add_point(x, y, text.number());
      corners.push_back(static_cast<std::uint32_t>(mesh.point_count() - 1));
    } else if (word == "endloop") {
      add_loop(corners, mesh, text.where());
    } else if (!word.empty() && word != "facet" && word != "outer" && word != "endfacet") {
      fail_mesh(escaped(word) + " is no word of STL", text.where());
    }
  }
  if (!corners.empty()) throw Error(ErrorKind::truncated, "the file ends within a triangle");
  mesh.weld();
  reading.mesh = mesh.take();
  return reading;
}

}  // namespace

MeshReading read_stl(ByteSpan bytes, std::uint64_t most_bytes) {
  // Files of bytes may begin with "solid" as those of text do; only they have the right length.
  const bool has_head = bytes.size() >= kStlHead;
  const std::uint64_t count = has_head ? stl_number<std::uint32_t>(bytes, kStlHead - 4) : 0;
  const bool is_exact = has_head && bytes.size() == kStlHead + count * kStlTriangle;
  if (!is_exact && text_of(bytes).starts_with("solid")) return read_text_stl(bytes, most_bytes);
  if (!has_head) throw Error(ErrorKind::truncated, "the file ends within the header of an STL");
  if (bytes.size() < kStlHead + count * kStlTriangle) {
    throw Error(ErrorKind::truncated,
                "the file ends before its " + count_text(static_cast<std::int64_t>(count)) +
                    " triangles do");
  }

  MeshGrowth mesh(most_bytes);
  MeshReading reading;
  reading.space = space_in(text_of(bytes.first(kStlHead - 4)));
  for (std::uint64_t i = 0; i < count; ++i) {
    const std::size_t at = kStlHead + static_cast<std::size_t>(i) * kStlTriangle + 12;
    MeshTriangle corners{};
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const std::size_t place = at + 12 * corner;
      mesh.add_point(stl_number<float>(bytes, place), stl_number<float>(bytes, place + 4),
                     stl_number<float>(bytes, place + 8));
      corners[corner] = static_cast<std::uint32_t>(mesh.point_count() - 1);
    }
    mesh.add_polygon(corners);
  }
  mesh.weld();
  reading.mesh = mesh.take();
  return reading;
}

}  // namespace octavo
