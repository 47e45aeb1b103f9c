#include <charconv>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/formats/mesh_readers.h"

namespace octavo {

namespace {

/// The point that the corner "7", "7/1" or "7//3" names; below 0 counted from the last one.
std::uint32_t obj_corner(std::string_view word, const MeshGrowth& mesh, const std::string& where) {
  const std::string_view digits = word.substr(0, word.find('/'));
  std::int64_t number = 0;
  const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (end.ec != std::errc() || end.ptr != digits.data() + digits.size()) {
    fail_mesh("a corner that is no number: " + escaped(word), where);
  }
  const auto count = static_cast<std::int64_t>(mesh.point_count());
  const bool is_point = (number >= 1 && number <= count) || (number <= -1 && number >= -count);
  if (!is_point) {
    fail_mesh("a corner at point " + std::to_string(number) + " of " + std::to_string(count),
              where);
  }
  return static_cast<std::uint32_t>(number > 0 ? number - 1 : count + number);
}

}  // namespace

MeshReading read_obj(ByteSpan bytes, std::uint64_t most_bytes) {
  MeshText text(text_of(bytes));
  MeshGrowth mesh(most_bytes);
  MeshReading reading;
  std::vector<std::uint32_t> corners;
  while (text.next_line()) {
    const std::string_view line = text.line();
    const std::string_view word = text.word();
    if (word == "v") {
      const double x = text.number();
      const double y = text.number();
      mesh.add_point(x, y, text.number());
    } else if (word == "f") {
      corners.clear();
      for (std::string_view at = text.word(); !at.empty(); at = text.word()) {
        corners.push_back(obj_corner(at, mesh, text.where()));
      }
      if (corners.size() < 3) fail_mesh("a face of fewer than three corners", text.where());
      mesh.add_polygon(corners);
    } else if (word.starts_with('#') && !reading.space) {
      reading.space = space_in(line);
    }
  }
  reading.mesh = mesh.take();
  return reading;
}

}  // namespace octavo
