#include <array>
#include <charconv>
#include <string>
#include <string_view>
#include <type_traits>

#include "octavo/mesh/hexahedra/file_text.h"
#include "octavo/mesh/hexahedra/hex_file.h"

namespace octavo {

namespace {

/// Items of one data line, then a new line.
class AbaqusLine {
 public:
  AbaqusLine(FileText& out, std::uint64_t items) : out_(out), items_(items) {}
  template <class T>
  void add(T item) {
    if (count_ != 0) out_.text(count_ % items_ == 0 ? "\n" : ", ");
    if constexpr (std::is_arithmetic_v<T>) out_.digits(item);
    else out_.text(item);
    ++count_;
  }
  void finish() {
    if (count_ != 0) out_.text("\n");
  }

 private:
  FileText& out_;
  std::uint64_t items_;
  std::uint64_t count_ = 0;
};

/// CalculiX reads 20 characters of a number: a sign, a point, an exponent and so many digits.
constexpr int kAbaqusDigits = 14;

class AbaqusWriter {
 public:
  AbaqusWriter(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
               PendingFile& file)
      : mesh_(mesh), names_(text.names), out_(file, watcher) {}

  void write(const HexFileText& text) {
    out_.text("*HEADING\nhexahedra, mm, LPS\n");
    for (const std::string& comment : text.comments) out_.text("** ").text(comment).text("\n");
    for_each_label([&](std::int64_t label, std::size_t, std::size_t) {
      if (!names_.all().contains(label)) return;
      out_.text("** ").text(label_set_name(label, names_)).text(": ");
      out_.text(label_line(label, names_)).text("\n");
    });
    nodes();
    elements();
    label_sets();
    for (std::size_t side = 0; side < 6; ++side) side_set(side);
    if (mesh_.hanging_count() != 0) equations();
    if (mesh_.has_materials()) materials(text);
    out_.finish();
  }

 private:
  void real(double value) {
    std::array<char, 32> digits;
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value,
                                   std::chars_format::general, kAbaqusDigits);
    out_.text({digits.data(), static_cast<std::size_t>(end.ptr - digits.data())});
  }

  void nodes() {
    out_.text("*NODE, NSET=ALL_NODES\n");
    std::uint64_t number = 0;
    mesh_.visit_nodes([&](const Point3& place) {
      out_.digits(++number);
      for (const double value : place) {
        out_.text(", ");
        real(value);
      }
      out_.text("\n");
    });
  }

  void elements() {
    constexpr std::array<const char*, 3> kTypes = {"C3D8", "C3D8", "C3D4"};
    std::uint64_t number = 0;
    for (std::size_t group = 0; group < mesh_.groups().size(); ++group) {
      for (const HexShape shape :
           {HexShape::hexahedron, HexShape::pyramid, HexShape::tetrahedron}) {
        const auto place = static_cast<std::size_t>(shape);
        const HexGroup& one = mesh_.groups()[group];
        if (one.element_counts[place] == 0) continue;
        out_.text("*ELEMENT, TYPE=").text(kTypes[place]).text(", ELSET=");
        out_.text(group_name(mesh_, group, names_)).text("\n");
        mesh_.visit_elements(one, shape, [&](std::span<const std::uint32_t> nodes, std::uint64_t) {
          out_.digits(++number);
          for (const std::uint32_t node : nodes) out_.text(", ").digits(std::uint64_t{node} + 1);
          // The upper face of a pyramid is its top, four times.
          if (shape == HexShape::pyramid) {
            for (int i = 0; i < 3; ++i) out_.text(", ").digits(std::uint64_t{nodes[4]} + 1);
          }
          out_.text("\n");
        });
      }
    }
  }

  /// All groups, and with materials those of each label.
  void label_sets() {
    set_of_groups("ALL_ELEMENTS", 0, mesh_.groups().size());
    if (!mesh_.has_materials()) return;
    for_each_label([&](std::int64_t label, std::size_t begin, std::size_t end) {
      set_of_groups(label_set_name(label, names_), begin, end);
    });
  }

  /// Calls visit(label, begin, end) with the groups of each label.
  template <class Visit>
  void for_each_label(Visit&& visit) const {
    const std::vector<HexGroup>& groups = mesh_.groups();
    for (std::size_t begin = 0, end = 0; begin < groups.size(); begin = end) {
      while (end < groups.size() && groups[end].label == groups[begin].label) ++end;
      visit(mesh_.labels()[groups[begin].label], begin, end);
    }
  }

  /// Of the groups [begin, end).
  void set_of_groups(const std::string& name, std::size_t begin, std::size_t end) {
    out_.text("*ELSET, ELSET=").text(name).text("\n");
    AbaqusLine line(out_, 4);
    for (std::size_t i = begin; i < end; ++i) {
      line.add(std::string_view(group_name(mesh_, i, names_)));
    }
    line.finish();
  }

  /// Of nodes that do not hang: those that do follow them.
  void side_set(std::size_t side) {
    const std::size_t axis = side / 2;
    const std::uint32_t at = mesh_.bounds()[side % 2][axis];
    const std::uint64_t free = mesh_.corners().count() - mesh_.hanging_count();
    out_.text("*NSET, NSET=").text(kSideNames[side]).text("\n");
    AbaqusLine line(out_, 16);
    mesh_.corners().visit([&](const GridPoint& point, std::uint32_t number) {
      if (number < free && point[axis] == at) line.add(std::uint64_t{number} + 1);
    });
    line.finish();
  }

  /// Each displacement of a hanging node is the mean of those of its masters.
  void equations() {
    out_.text("*EQUATION\n");
    mesh_.corners().visit_hanging([&](const GridPoint& point, std::uint32_t number) {
      const HexMasters masters = mesh_.corners().masters_of(point);
      const std::string_view weight = masters.count == 2 ? ", -0.5" : ", -0.25";
      for (int axis = 1; axis <= 3; ++axis) {
        out_.digits(masters.count + 1).text("\n").digits(std::uint64_t{number} + 1);
        out_.text(", ").digits(axis).text(", 1");
        for (int i = 0; i < masters.count; ++i) {
          // Four terms fill a line.
          out_.text(i == 3 ? "\n" : ", ");
          out_.digits(std::uint64_t{masters.nodes[static_cast<std::size_t>(i)]} + 1);
          out_.text(", ").digits(axis).text(weight);
        }
        out_.text("\n");
      }
    });
  }

  void materials(const HexFileText& text) {
    constexpr double kTonnePerMm3 = 1e-9;  // of 1 g/cm3
    for (std::size_t i = 0; i < mesh_.groups().size(); ++i) {
      const HexMaterial& material = *mesh_.groups()[i].material;
      const std::string number = std::to_string(i + 1);
      out_.text("*MATERIAL, NAME=MATERIAL_").text(number).text("\n*ELASTIC\n");
      real(material.modulus_mpa);
      out_.text(", ");
      real(text.poisson_ratio);
      if (material.density_g_cm3 > 0) {
        out_.text("\n*DENSITY\n");
        real(material.density_g_cm3 * kTonnePerMm3);
      }
      out_.text("\n*SOLID SECTION, ELSET=").text(group_name(mesh_, i, names_));
      out_.text(", MATERIAL=MATERIAL_").text(number).text("\n");
    }
  }

  const HexMesh& mesh_;
  const LabelNames& names_;
  FileText out_;
};

}  // namespace

void write_hex_abaqus(const HexMesh& mesh, const HexFileText& text, const Progress& watcher,
                      PendingFile& file) {
  AbaqusWriter(mesh, text, watcher, file).write(text);
}

}  // namespace octavo
