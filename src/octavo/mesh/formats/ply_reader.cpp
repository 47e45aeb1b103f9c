#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/mesh/formats/mesh_readers.h"

namespace octavo {

namespace {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct NamedPlyType {
  std::string_view name;
  PlyType type;
};

constexpr NamedPlyType kPlyTypes[] = {
    {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
    {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
    {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
    {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
    {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
    {"float64", PlyType::float64}};

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  std::optional<PlyType> count_type;  // of lists
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

enum class PlyForm { text, little, big };

struct PlyHeader {
  PlyForm form = PlyForm::text;
  std::vector<PlyElement> elements;
  std::optional<MeshSpace> space;
};

PlyType ply_type(std::string_view name, const std::string& where) {
  for (const NamedPlyType& one : kPlyTypes) {
    if (one.name == name) return one.type;
  }
  fail_mesh(escaped(name) + " is no type of PLY", where);
}

PlyForm ply_form(std::string_view name, const std::string& where) {
  if (name == "ascii") return PlyForm::text;
  if (name == "binary_little_endian") return PlyForm::little;
  if (name == "binary_big_endian") return PlyForm::big;
  fail_mesh(escaped(name) + " is no form of PLY", where);
}

PlyElement ply_element(MeshText& text) {
  PlyElement element;
  element.name = text.word();
  const std::string_view count = text.word();
  const auto end = std::from_chars(count.data(), count.data() + count.size(), element.count);
  if (count.empty() || end.ec != std::errc() || end.ptr != count.data() + count.size()) {
    fail_mesh("an element without a number", text.where());
  }
  return element;
}

PlyProperty ply_property(MeshText& text) {
  PlyProperty property;
  std::string_view word = text.word();
  if (word == "list") {
    property.count_type = ply_type(text.word(), text.where());
    word = text.word();
  }
  property.type = ply_type(word, text.where());
  property.name = text.word();
  return property;
}

/// The header; the text stands behind it then.
PlyHeader ply_header(MeshText& text) {
  if (!text.next_line() || text.word() != "ply") {
    throw Error(ErrorKind::corrupt, "the file does not begin as a PLY does");
  }
  PlyHeader header;
  bool has_form = false;
  while (text.next_line()) {
    const std::string_view line = text.line();
    const std::string_view word = text.word();
    if (word == "format") {
      header.form = ply_form(text.word(), text.where());
      has_form = true;
    } else if (word == "element") {
      header.elements.push_back(ply_element(text));
    } else if (word == "property") {
      if (header.elements.empty()) fail_mesh("a property of no element", text.where());
      header.elements.back().properties.push_back(ply_property(text));
    } else if (word == "end_header") {
      if (!has_form) fail_mesh("the header has no format", text.where());
      return header;
    } else if (word == "comment" || word == "obj_info") {
      if (!header.space) header.space = space_in(line);
    } else if (!word.empty()) {
      fail_mesh(escaped(word) + " is no word of a header", text.where());
    }
  }
  throw Error(ErrorKind::truncated, "the file ends within the header of a PLY");
}

/// Number after number, of text or of bytes.
class PlyNumbers {
 public:
  PlyNumbers(MeshText text, PlyForm form) : form_(form), text_(text), rest_(text.rest()) {}

  double next(PlyType type) {
    if (form_ == PlyForm::text) return next_word();
    switch (type) {
      case PlyType::int8: return take<std::int8_t>();
      case PlyType::uint8: return take<std::uint8_t>();
      case PlyType::int16: return take<std::int16_t>();
      case PlyType::uint16: return take<std::uint16_t>();
      case PlyType::int32: return take<std::int32_t>();
      case PlyType::uint32: return take<std::uint32_t>();
      case PlyType::float32: return take<float>();
      default: return take<double>();
    }
  }

  /// How many items the list has that comes next.
  std::uint64_t next_count(PlyType type, const std::string& where) {
    const double count = next(type);
    if (!(count >= 0 && count <= std::numeric_limits<std::uint32_t>::max()) ||
        count != std::floor(count)) {
      fail_mesh("a list of no length", where);
    }
    return static_cast<std::uint64_t>(count);
  }

 private:
  [[noreturn]] static void fail_short() {
    throw Error(ErrorKind::truncated, "the file ends before its points and faces do");
  }

  double next_word() {
    std::string_view word = text_.word();
    while (word.empty()) {
      if (!text_.next_line()) fail_short();
      word = text_.word();
    }
    if (const auto number = number_in_word(word)) return *number;
    fail_mesh(escaped(word) + " is no number", text_.where());
  }

  template <class T>
  T take() {
    if (rest_.size() < sizeof(T)) fail_short();
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), rest_.data(), sizeof(T));
    if (form_ == PlyForm::big) std::reverse(bytes.begin(), bytes.end());
    rest_.remove_prefix(sizeof(T));
    return std::bit_cast<T>(bytes);
  }

  PlyForm form_;
  MeshText text_;
  std::string_view rest_;
};

void read_vertices(const PlyElement& element, PlyNumbers& in, MeshGrowth& mesh) {
  constexpr std::array<std::string_view, 3> kAxes = {"x", "y", "z"};
  for (const std::string_view axis : kAxes) {
    const bool has_axis = std::any_of(
        element.properties.begin(), element.properties.end(),
        [&](const PlyProperty& p) { return p.name == axis && !p.count_type; });
    if (!has_axis) fail_mesh("no property " + std::string(axis), "element vertex");
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    std::array<double, 3> point{};
    for (const PlyProperty& property : element.properties) {
      const std::uint64_t count =
          property.count_type ? in.next_count(*property.count_type, "element vertex") : 1;
      for (std::uint64_t n = 0; n < count; ++n) {
        const double value = in.next(property.type);
        for (std::size_t axis = 0; axis < 3; ++axis) {
          if (property.name == kAxes[axis]) point[axis] = value;
        }
      }
    }
    mesh.add_point(point[0], point[1], point[2]);
  }
}

std::uint32_t ply_corner(double number, const MeshGrowth& mesh, const std::string& where) {
  const auto count = static_cast<double>(mesh.point_count());
  if (!(number >= 0 && number < count) || number != std::floor(number)) {
    fail_mesh("a corner that is none of the " + std::to_string(mesh.point_count()) + " points",
              where);
  }
  return static_cast<std::uint32_t>(number);
}

bool is_of_corners(const PlyProperty& property) {
  return property.count_type &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

void read_faces(const PlyElement& element, PlyNumbers& in, MeshGrowth& mesh) {
  if (std::none_of(element.properties.begin(), element.properties.end(), is_of_corners)) {
    fail_mesh("no list vertex_indices", "element face");
  }
  std::vector<std::uint32_t> corners;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    const std::string where = "face " + std::to_string(i + 1);
    for (const PlyProperty& property : element.properties) {
      const bool has_corners = is_of_corners(property);
      if (has_corners) corners.clear();
      const std::uint64_t count =
          property.count_type ? in.next_count(*property.count_type, where) : 1;
      for (std::uint64_t n = 0; n < count; ++n) {
        const double value = in.next(property.type);
        if (has_corners) corners.push_back(ply_corner(value, mesh, where));
      }
    }
    mesh.add_polygon(corners);
  }
}

void skip_element(const PlyElement& element, PlyNumbers& in) {
  if (element.properties.empty()) return;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    for (const PlyProperty& property : element.properties) {
      const std::uint64_t count =
          property.count_type ? in.next_count(*property.count_type, escaped(element.name)) : 1;
      for (std::uint64_t n = 0; n < count; ++n) in.next(property.type);
    }
  }
}

MeshReading parsed_ply(ByteSpan bytes, std::uint64_t most_bytes) {
  MeshText text(text_of(bytes));
  const PlyHeader header = ply_header(text);
  PlyNumbers in(text, header.form);
  MeshGrowth mesh(most_bytes);
  for (const PlyElement& element : header.elements) {
    if (element.name == "vertex") read_vertices(element, in, mesh);
    else if (element.name == "face") read_faces(element, in, mesh);
    else skip_element(element, in);
  }
  MeshReading reading;
  reading.space = header.space;
  reading.mesh = mesh.take_any();
  return reading;
}

}  // namespace

MeshReading read_point_ply(ByteSpan bytes, std::uint64_t most_bytes) {
  MeshReading reading = parsed_ply(bytes, most_bytes);
  if (reading.mesh.points.empty()) {
    throw Error(ErrorKind::source_rejected, "the file has no points");
  }
  return reading;
}

MeshReading read_ply(ByteSpan bytes, std::uint64_t most_bytes) {
  MeshReading reading = parsed_ply(bytes, most_bytes);
  require_triangles(reading.mesh);
  return reading;
}

}  // namespace octavo
