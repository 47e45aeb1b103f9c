#include <algorithm>
#include <string>
#include <vector>

#include "octavo/core/label_color.h"
#include "octavo/mesh/hexahedra/file_text.h"
#include "octavo/mesh/hexahedra/hex_file.h"

namespace octavo {

namespace {

constexpr std::uint8_t vtk_type(HexShape shape) {
  return shape == HexShape::hexahedron ? 12 : shape == HexShape::pyramid ? 14 : 10;
}

/// The arrays of a mesh, whose sizes are said before any is written.
class VtuWriter {
 public:
  VtuWriter(const HexMesh& mesh, const Progress& watcher, PendingFile& file)
      : mesh_(mesh), out_(file, watcher) {}

  void write(const HexFileText& text) {
    begin(text);
    for (const bool is_data : {false, true}) {
      is_data_ = is_data;
      offset_ = 0;
      arrays();
      if (!is_data) out_.text("</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    }
    out_.text("\n</AppendedData>\n</VTKFile>\n");
    out_.finish();
  }

 private:
  void begin(const HexFileText& text) {
    out_.text("<?xml version=\"1.0\"?>\n");
    for (const std::string& comment : text.comments) {
      out_.text("<!-- ").text(comment).text(" -->\n");
    }
    out_.text(
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
        "header_type=\"UInt64\">\n<UnstructuredGrid>\n");
    label_fields(text.names);
    out_.text("<Piece NumberOfPoints=\"");
    out_.digits(mesh_.node_count()).text("\" NumberOfCells=\"");
    out_.digits(mesh_.element_count()).text("\">\n");
  }

  /// What the labels of the elements are called, and their colors; those without a name by number.
  void label_fields(const LabelNames& names) {
    std::vector<std::int64_t> labels;
    for (const HexGroup& group : mesh_.groups()) {
      const std::int64_t label = mesh_.labels()[group.label];
      if (labels.empty() || labels.back() != label) labels.push_back(label);
    }
    const bool is_named = std::any_of(labels.begin(), labels.end(), [&](std::int64_t label) {
      return names.all().contains(label);
    });
    if (!is_named) return;
    out_.text("<FieldData>\n");
    begin_field("Int64", "labels", labels.size(), 1);
    for (const std::int64_t label : labels) out_.digits(label).text(" ");
    out_.text("</DataArray>\n");
    begin_field("String", "label_names", labels.size(), 1);
    for (const std::int64_t label : labels) {
      for (const char letter : names.text_of(label)) {
        out_.digits(unsigned{static_cast<unsigned char>(letter)}).text(" ");
      }
      out_.text("0\n");
    }
    out_.text("</DataArray>\n");
    begin_field("UInt8", "label_colors", labels.size(), 3);
    for (const std::int64_t label : labels) {
      for (const std::uint8_t value : names.color_of(label, label_color(label))) {
        out_.digits(unsigned{value}).text(" ");
      }
    }
    out_.text("</DataArray>\n</FieldData>\n");
  }

  void begin_field(const char* type, const char* name, std::size_t tuples, int components) {
    out_.text("<DataArray type=\"").text(type).text("\" Name=\"").text(name);
    out_.text("\" NumberOfComponents=\"").digits(components);
    out_.text("\" NumberOfTuples=\"").digits(tuples).text("\" format=\"ascii\">\n");
  }

  void tag(const char* text) {
    if (!is_data_) out_.text(text);
  }

  /// One array of `count` numbers of T: what is said of it, or in the second round what `fill`
  /// writes.
  template <class T, class Fill>
  void array(const char* type, const char* name, int components, std::uint64_t count,
             Fill&& fill) {
    const std::uint64_t bytes = count * sizeof(T);
    if (is_data_) {
      out_.number(bytes);
      fill();
    } else {
      out_.text("<DataArray type=\"").text(type).text("\" Name=\"").text(name).text("\"");
      if (components > 1) out_.text(" NumberOfComponents=\"").digits(components).text("\"");
      out_.text(" format=\"appended\" offset=\"").digits(offset_).text("\"/>\n");
    }
    offset_ += sizeof(std::uint64_t) + bytes;
  }

  /// An array with a number for each element, which `value` gives for its cell.
  template <class T, class Value>
  void cell_array(const char* type, const char* name, Value&& value) {
    array<T>(type, name, 1, mesh_.element_count(), [&] {
      mesh_.visit_all_elements([&](HexShape, auto, std::uint64_t cell) {
        out_.number(static_cast<T>(value(cell)));
      });
    });
  }

  void arrays() {
    tag("<Points>\n");
    array<double>("Float64", "Points", 3, 3 * mesh_.node_count(), [&] {
      mesh_.visit_nodes([&](const Point3& place) { out_.number(place); });
    });
    tag("</Points>\n<Cells>\n");
    topology();
    tag("</Cells>\n<PointData>\n");
    if (mesh_.hanging_count() != 0) masters();
    tag("</PointData>\n<CellData>\n");
    cell_data();
    tag("</CellData>\n");
  }

  void topology() {
    std::uint64_t links = 0;
    for (const HexGroup& group : mesh_.groups()) {
      const auto& counts = group.element_counts;
      links += 8 * counts[0] + 5 * counts[1] + 4 * counts[2];
    }
    array<std::int64_t>("Int64", "connectivity", 1, links, [&] {
      mesh_.visit_all_elements([&](HexShape, std::span<const std::uint32_t> nodes, std::uint64_t) {
        for (const std::uint32_t node : nodes) out_.number(std::int64_t{node});
      });
    });
    array<std::int64_t>("Int64", "offsets", 1, mesh_.element_count(), [&] {
      std::int64_t end = 0;
      mesh_.visit_all_elements([&](HexShape shape, auto, std::uint64_t) {
        out_.number(end += point_count(shape));
      });
    });
    array<std::uint8_t>("UInt8", "types", 1, mesh_.element_count(), [&] {
      mesh_.visit_all_elements(
          [&](HexShape shape, auto, std::uint64_t) { out_.number(vtk_type(shape)); });
    });
  }

  /// The nodes that each one is the mean of, and -1; of those that do not hang none.
  void masters() {
    array<std::int32_t>("Int32", "masters", 4, 4 * mesh_.node_count(), [&] {
      const std::array<std::int32_t, 4> none = {-1, -1, -1, -1};
      const std::uint64_t free = mesh_.node_count() - mesh_.hanging_count();
      for (std::uint64_t i = 0; i < free; ++i) out_.number(none);
      mesh_.corners().visit_hanging([&](const GridPoint& point, std::uint32_t) {
        const HexMasters masters = mesh_.corners().masters_of(point);
        std::array<std::int32_t, 4> nodes = none;
        for (std::size_t i = 0; i < static_cast<std::size_t>(masters.count); ++i) {
          nodes[i] = static_cast<std::int32_t>(masters.nodes[i]);
        }
        out_.number(nodes);
      });
    });
  }

  void cell_data() {
    const auto& cells = mesh_.cells();
    const CellValues& values = mesh_.values();
    cell_array<std::uint8_t>("UInt8", "level", [&](std::uint64_t cell) {
      return cells[cell].level;
    });
    cell_array<std::int64_t>("Int64", "label", [&](std::uint64_t cell) {
      return mesh_.labels()[cells[cell].label];
    });
    const auto floats = [&](const char* name, const std::vector<float>& of_cells) {
      if (of_cells.empty()) return;
      cell_array<float>("Float32", name, [&](std::uint64_t cell) { return of_cells[cell]; });
    };
    floats("mean", values.mean);
    floats("density_g_cm3", values.density_g_cm3);
    floats("modulus_mpa", values.modulus_mpa);
    if (!mesh_.has_materials()) return;
    array<std::int32_t>("Int32", "material", 1, mesh_.element_count(), [&] {
      std::int32_t number = 0;
      for (const HexGroup& group : mesh_.groups()) {
        ++number;
        for (std::uint64_t i = 0; i < group.element_count(); ++i) out_.number(number);
      }
    });
  }

  const HexMesh& mesh_;
  FileText out_;
  bool is_data_ = false;
  std::uint64_t offset_ = 0;
};

}  // namespace

void write_hex_vtu(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                   PendingFile& file) {
  VtuWriter(mesh, watcher, file).write(text);
}

}  // namespace octavo
