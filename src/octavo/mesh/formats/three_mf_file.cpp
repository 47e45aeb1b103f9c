// 3MF, the core specification 1.3: a zip archive with a model in XML.
#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"
#include "octavo/mesh/formats/used_points.h"
#include "octavo/mesh/formats/xml_text.h"
#include "octavo/mesh/formats/zip_archive.h"

namespace octavo {

namespace {

constexpr std::string_view kContentTypes =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\n"
    "<Default Extension=\"rels\" "
    "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\n"
    "<Default Extension=\"model\" "
    "ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\n"
    "</Types>\n";

constexpr std::string_view kRelations =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\n"
    "<Relationship Target=\"/3D/3dmodel.model\" Id=\"model\" "
    "Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>\n"
    "</Relationships>\n";

/// Materials have this number, objects those behind it.
constexpr std::size_t kMaterials = 1;

std::string color_text(const LabelColor& color) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string text = "#";
  for (const std::uint8_t value : color) {
    text += kDigits[value >> 4];
    text += kDigits[value & 15];
  }
  return text;
}

class ModelWriter {
 public:
  ModelWriter(const MeshDescription& described, const Progress& watcher, ZipArchive& archive)
      : described_(described),
        parts_(objects_of(described)),
        out_([&archive](ByteSpan bytes) { archive.append(bytes); }, watcher) {}

  void write() {
    out_.text(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
        "<model unit=\"millimeter\" xml:lang=\"en-US\" "
        "xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n"
        "<metadata name=\"Application\">octavo</metadata>\n");
    write_description();
    out_.text("<resources>\n");
    write_materials();
    UsedPoints points(described_.mesh);
    for (std::size_t i = 0; i < parts_.size(); ++i) write_object(i, points);
    out_.text("</resources>\n<build>\n");
    const std::string placed = placed_text();
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      out_.text("<item objectid=\"" + std::to_string(number_of(i)) + "\" transform=\"" + placed +
                "\"/>\n");
    }
    out_.text("</build>\n</model>\n");
    out_.flush();
  }

 private:
  static std::size_t number_of(std::size_t object) { return kMaterials + 1 + object; }

  void write_description() {
    std::string text;
    for (const std::string& comment : described_.comments) text += xml_text(comment) + "\n";
    text += space_words(described_.space);
    if (!described_.report.empty()) text += "\nreport " + xml_text(described_.report);
    out_.text("<metadata name=\"Description\">" + text + "</metadata>\n");
  }

  void write_materials() {
    if (std::none_of(parts_.begin(), parts_.end(),
                     [](const MeshPart& part) { return part.color; })) {
      return;
    }
    out_.text("<basematerials id=\"" + std::to_string(kMaterials) + "\">\n");
    for (const MeshPart& part : parts_) {
      out_.text("<base name=\"" + xml_text(part_name(part)) + "\" displaycolor=\"" +
                color_text(part.color.value_or(kPlainColor)) + "\"/>\n");
    }
    out_.text("</basematerials>\n");
    has_materials_ = true;
  }

  void write_object(std::size_t object, UsedPoints& points) {
    const MeshPart& part = parts_[object];
    out_.text("<object id=\"" + std::to_string(number_of(object)) + "\" type=\"model\" name=\"" +
              xml_text(part_name(part)) + "\"");
    if (has_materials_) {
      out_.text(" pid=\"" + std::to_string(kMaterials) + "\" pindex=\"" + std::to_string(object) +
                "\"");
    }
    out_.text(">\n<mesh>\n<vertices>\n");
    points.take(part.begin, part.end);
    for (const std::uint32_t point : points.points()) {
      const MeshPoint place = in_space(described_.mesh.points[point], described_.space);
      write_three("<vertex x=\"", "\" y=\"", "\" z=\"", place);
    }
    out_.text("</vertices>\n<triangles>\n");
    for (std::size_t i = part.begin; i < part.end; ++i) {
      write_three("<triangle v1=\"", "\" v2=\"", "\" v3=\"", points.triangle(i));
    }
    out_.text("</triangles>\n</mesh>\n</object>\n");
  }

  template <class Number>
  void write_three(std::string_view first, std::string_view second, std::string_view third,
                   const std::array<Number, 3>& numbers) {
    out_.text(first);
    write_number(numbers[0]);
    out_.text(second);
    write_number(numbers[1]);
    out_.text(third);
    write_number(numbers[2]);
    out_.text("\"/>\n");
  }

  void write_number(float value) { out_.text(coordinate_text(value)); }
  void write_number(std::uint32_t value) { out_.digits(value); }

  /// Moves all objects together to where printers have their plate: no coordinate is negative.
  std::string placed_text() const {
    MeshPoint lowest{};
    bool is_first = true;
    for (const MeshPoint& point : described_.mesh.points) {
      const MeshPoint place = in_space(point, described_.space);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        lowest[axis] = is_first ? place[axis] : std::min(lowest[axis], place[axis]);
      }
      is_first = false;
    }
    std::string text = "1 0 0 0 1 0 0 0 1";
    for (const float value : lowest) text += " " + coordinate_text(0 - value);
    return text;
  }

  const MeshDescription& described_;
  std::vector<MeshPart> parts_;
  bool has_materials_ = false;
  MeshBytes out_;
};

}  // namespace

void write_three_mf(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  constexpr std::uint64_t kPointXmlBytes = 80;
  constexpr std::uint64_t kTriangleXmlBytes = 70;
  constexpr std::uint64_t kLarge = std::uint64_t{1} << 32;
  const TriangleMesh& mesh = described.mesh;
  // An object has points of its own, so that some points are written more than once.
  const std::uint64_t xml_bytes =
      (3 * kPointXmlBytes + kTriangleXmlBytes) * mesh.triangles.size();
  require_countable(mesh.points.size(), std::uint64_t{1} << 31, "points", file);

  ZipArchive archive(file);
  const auto append_text = [&](std::string_view text) {
    archive.append({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  archive.begin("[Content_Types].xml");
  append_text(kContentTypes);
  archive.begin("_rels/.rels");
  append_text(kRelations);
  archive.begin("3D/3dmodel.model", xml_bytes >= kLarge);
  ModelWriter(described, watcher, archive).write();
  archive.finish();
}

}  // namespace octavo
