#include <algorithm>
#include <string>

#include "octavo/mesh/hexahedra/file_text.h"
#include "octavo/mesh/hexahedra/hex_file.h"

namespace octavo {

namespace {

constexpr int gmsh_type(HexShape shape) {
  return shape == HexShape::hexahedron ? 5 : shape == HexShape::pyramid ? 7 : 4;
}

class GmshWriter {
 public:
  GmshWriter(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
             PendingFile& file)
      : mesh_(mesh), names_(text.names), attributes_(group_attributes(mesh)), out_(file, watcher) {}

  void write(const HexFileText& text) {
    out_.text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Comments\n");
    for (const std::string& comment : text.comments) out_.text(comment).text("\n");
    std::uint32_t last = static_cast<std::uint32_t>(mesh_.labels().size());
    for (const HexGroup& group : mesh_.groups()) {
      const std::int64_t label = mesh_.labels()[group.label];
      if (group.label == last || !names_.all().contains(label)) continue;
      last = group.label;
      out_.text(label_set_name(label, names_)).text(": ");
      out_.text(label_line(label, names_)).text("\n");
    }
    out_.text("$EndComments\n");
    volumes();
    nodes();
    elements();
    out_.finish();
  }

 private:
  /// A volume for each group, and its name.
  void volumes() {
    const std::size_t count = mesh_.groups().size();
    out_.text("$PhysicalNames\n").digits(count).text("\n");
    for (std::size_t i = 0; i < count; ++i) {
      out_.text("3 ").digits(attributes_[i]).text(" \"");
      out_.text(group_name(mesh_, i, names_)).text("\"\n");
    }
    out_.text("$EndPhysicalNames\n$Entities\n0 0 0 ").digits(count).text("\n");
    const Box3 box = box_mm();
    for (std::size_t i = 0; i < count; ++i) {
      out_.digits(i + 1);
      for (const Point3& corner : box) {
        for (const double value : corner) out_.text(" ").digits(value);
      }
      out_.text(" 1 ").digits(attributes_[i]).text(" 0\n");
    }
    out_.text("$EndEntities\n");
  }

  using Box3 = std::array<Point3, 2>;

  Box3 box_mm() const {
    Box3 box;
    const auto& bounds = mesh_.bounds();
    for (std::size_t i = 0; i < 8; ++i) {
      const Point3 place = mesh_.place_of({static_cast<double>(bounds[i & 1][0]),
                                           static_cast<double>(bounds[i >> 1 & 1][1]),
                                           static_cast<double>(bounds[i >> 2][2])});
      for (std::size_t axis = 0; axis < 3; ++axis) {
        box[0][axis] = i == 0 ? place[axis] : std::min(box[0][axis], place[axis]);
        box[1][axis] = i == 0 ? place[axis] : std::max(box[1][axis], place[axis]);
      }
    }
    return box;
  }

  void nodes() {
    const std::uint64_t count = mesh_.node_count();
    out_.text("$Nodes\n1 ").digits(count).text(" 1 ").digits(count).text("\n3 1 0 ");
    out_.digits(count).text("\n");
    for (std::uint64_t i = 1; i <= count; ++i) out_.digits(i).text("\n");
    mesh_.visit_nodes([&](const Point3& place) {
      out_.digits(place[0]).text(" ").digits(place[1]).text(" ").digits(place[2]).text("\n");
    });
    out_.text("$EndNodes\n");
  }

  void elements() {
    std::uint64_t blocks = 0;
    for (const HexGroup& group : mesh_.groups()) {
      for (const std::uint64_t count : group.element_counts) blocks += count != 0 ? 1 : 0;
    }
    const std::uint64_t all = mesh_.element_count();
    out_.text("$Elements\n").digits(blocks).text(" ").digits(all).text(" 1 ").digits(all);
    out_.text("\n");
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < mesh_.groups().size(); ++i) {
      for (const HexShape shape :
           {HexShape::hexahedron, HexShape::pyramid, HexShape::tetrahedron}) {
        const HexGroup& group = mesh_.groups()[i];
        const std::uint64_t count = group.element_counts[static_cast<std::size_t>(shape)];
        if (count == 0) continue;
        out_.text("3 ").digits(i + 1).text(" ").digits(gmsh_type(shape)).text(" ");
        out_.digits(count).text("\n");
        mesh_.visit_elements(group, shape,
                             [&](std::span<const std::uint32_t> nodes, std::uint64_t) {
          out_.digits(++number);
          for (const std::uint32_t node : nodes) out_.text(" ").digits(std::uint64_t{node} + 1);
          out_.text("\n");
        });
      }
    }
    out_.text("$EndElements\n");
  }

  const HexMesh& mesh_;
  const LabelNames& names_;
  std::vector<std::int64_t> attributes_;  // of groups
  FileText out_;
};

}  // namespace

void write_hex_gmsh(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                    PendingFile& file) {
  GmshWriter(mesh, text, watcher, file).write(text);
}

}  // namespace octavo
