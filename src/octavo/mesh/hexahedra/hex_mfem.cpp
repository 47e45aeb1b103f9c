#include <string>

#include "octavo/mesh/hexahedra/file_text.h"
#include "octavo/mesh/hexahedra/hex_file.h"

namespace octavo {

namespace {

constexpr int mfem_type(HexShape shape) {
  return shape == HexShape::hexahedron ? 5 : shape == HexShape::pyramid ? 7 : 4;
}

class MfemWriter {
 public:
  MfemWriter(const HexMesh& mesh, const Progress& watcher, PendingFile& file)
      : mesh_(mesh), attributes_(group_attributes(mesh)), out_(file, watcher) {}

  void write(const HexFileText& text) {
    const bool has_hanging = mesh_.hanging_count() != 0;
    out_.text(has_hanging ? "MFEM mesh v1.1\n\n" : "MFEM mesh v1.0\n\n");
    for (const std::string& comment : text.comments) out_.text("# ").text(comment).text("\n");
    attributes(text.names);
    out_.text("\ndimension\n3\n");
    elements();
    boundary();
    if (has_hanging) parents();
    out_.text("\nvertices\n").digits(mesh_.node_count()).text("\n3\n");
    mesh_.visit_nodes([&](const Point3& place) {
      out_.digits(place[0]).text(" ").digits(place[1]).text(" ").digits(place[2]).text("\n");
    });
    out_.finish();
  }

 private:
  void line(std::int64_t attribute, int type, std::span<const std::uint32_t> nodes) {
    out_.digits(attribute).text(" ").digits(type);
    for (const std::uint32_t node : nodes) out_.text(" ").digits(node);
    out_.text("\n");
  }

  /// Comments, since attributes have no names in these versions of the format.
  void attributes(const LabelNames& names) {
    for (std::size_t i = 0; i < mesh_.groups().size(); ++i) {
      const HexGroup& group = mesh_.groups()[i];
      out_.text("# attribute ").digits(attributes_[i]);
      out_.text(" = ").text(label_line(mesh_.labels()[group.label], names));
      if (group.material) out_.text(", ").digits(group.material->modulus_mpa).text(" MPa");
      out_.text("\n");
    }
  }

  void elements() {
    out_.text("\nelements\n").digits(mesh_.element_count()).text("\n");
    for (std::size_t i = 0; i < mesh_.groups().size(); ++i) {
      const std::int64_t attribute = attributes_[i];
      for (const HexShape shape :
           {HexShape::hexahedron, HexShape::pyramid, HexShape::tetrahedron}) {
        mesh_.visit_elements(mesh_.groups()[i], shape,
                             [&](std::span<const std::uint32_t> nodes, std::uint64_t) {
          line(attribute, mfem_type(shape), nodes);
        });
      }
    }
  }

  void boundary() {
    std::uint64_t count = 0;
    mesh_.visit_side_faces([&](int, std::span<const std::uint32_t>) { ++count; });
    out_.text("\nboundary\n").digits(count).text("\n");
    mesh_.visit_side_faces([&](int side, std::span<const std::uint32_t> nodes) {
      line(side + 1, nodes.size() == 4 ? 3 : 2, nodes);
    });
  }

  /// The middle of an edge has its ends as parents, that of a face the middles of two edges.
  void parents() {
    out_.text("\nvertex_parents\n").digits(mesh_.hanging_count()).text("\n");
    mesh_.corners().visit_hanging([&](const GridPoint& point, std::uint32_t number) {
      const auto [first, second] = parents_of(point);
      out_.digits(number).text(" ").digits(first).text(" ").digits(second).text("\n");
    });
  }

  std::array<std::uint32_t, 2> parents_of(const GridPoint& point) const {
    const HexNodes& nodes = mesh_.corners();
    const HexMasters masters = nodes.masters_of(point);
    if (masters.count == 2) return {masters.nodes[0], masters.nodes[1]};
    const std::uint32_t step = std::uint32_t{1} << std::countr_zero(point[0] | point[1] | point[2]);
    std::array<std::uint32_t, 2> pair{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if ((point[axis] & step) == 0) continue;
      GridPoint before = point;
      GridPoint behind = point;
      before[axis] -= step;
      behind[axis] += step;
      pair = {nodes.number_at(before), nodes.number_at(behind)};
      if (pair[0] != HexNodes::kNone && pair[1] != HexNodes::kNone) break;
    }
    return pair;
  }

  const HexMesh& mesh_;
  std::vector<std::int64_t> attributes_;  // of groups
  FileText out_;
};

}  // namespace

void write_hex_mfem(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                    PendingFile& file) {
  MfemWriter(mesh, watcher, file).write(text);
}

}  // namespace octavo
