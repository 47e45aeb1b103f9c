#include <cstdint>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/mesh/formats/mesh_formats.h"

namespace octavo {

namespace {

/// An array of text in the header: character codes, a 0 behind every text.
std::string vtp_texts(const std::string& name, const std::vector<std::string>& texts) {
  std::string xml = "<DataArray type=\"String\" Name=\"" + name + "\" NumberOfTuples=\"" +
                    std::to_string(texts.size()) + "\" format=\"ascii\">\n";
  for (const std::string& text : texts) {
    for (const char letter : text) {
      xml += std::to_string(static_cast<unsigned char>(letter)) + " ";
    }
    xml += "0\n";
  }
  return xml + "</DataArray>\n";
}

/// What is said of the whole mesh, and what its labels are called.
std::string vtp_fields(const MeshDescription& described) {
  std::vector<std::string> comments(described.comments.begin(), described.comments.end());
  comments.push_back(space_words(described.space));
  std::string xml = "<FieldData>\n" + vtp_texts("comments", comments);
  if (!described.report.empty()) xml += vtp_texts("report", {described.report});
  if (has_part_labels(described)) {
    std::string labels;
    std::vector<std::string> names;
    for (const MeshPart& part : described.parts) {
      labels += std::to_string(*part.label) + " ";
      names.push_back(part.name);
    }
    xml += "<DataArray type=\"Int64\" Name=\"labels\" NumberOfTuples=\"" +
           std::to_string(described.parts.size()) + "\" format=\"ascii\">" + labels +
           "</DataArray>\n" + vtp_texts("label_names", names);
  }
  return xml + "</FieldData>\n";
}

/// The arrays behind the header, each after its size in bytes.
class VtpArrays {
 public:
  /// The element of an array of `bytes` bytes that comes next.
  std::string element(std::string_view type, std::string_view name, int components,
                      std::uint64_t bytes) {
    std::string xml = "<DataArray type=\"" + std::string(type) + "\" Name=\"" + std::string(name) +
                      "\" NumberOfComponents=\"" + std::to_string(components) +
                      "\" format=\"appended\" offset=\"" + std::to_string(offset_) + "\"/>\n";
    offset_ += sizeof(std::uint64_t) + bytes;
    return xml;
  }

 private:
  std::uint64_t offset_ = 0;
};

class VtpWriter {
 public:
  VtpWriter(const MeshDescription& described, const Progress& watcher, PendingFile& file)
      : described_(described),
        point_count_(described.mesh.points.size()),
        triangle_count_(described.mesh.triangles.size()),
        has_labels_(has_part_labels(described)),
        out_(file, watcher) {
    constexpr std::uint64_t kMost = std::numeric_limits<std::int32_t>::max();
    is_wide_ = point_count_ > kMost || 3 * triangle_count_ > kMost;
  }

  void write() {
    write_header();
    if (!described_.normals.empty()) write_places(described_.normals);
    write_labels();
    write_places(described_.mesh.points);
    if (is_wide_) write_numbers<std::int64_t>();
    else write_numbers<std::int32_t>();
    out_.text("\n</AppendedData>\n</VTKFile>\n");
    out_.flush();
  }

 private:
  std::uint64_t number_bytes() const { return is_wide_ ? 8 : 4; }

  void write_header() {
    const std::string_view number = is_wide_ ? "Int64" : "Int32";
    const std::uint64_t place_bytes = sizeof(MeshPoint) * point_count_;
    VtpArrays arrays;
    std::string xml =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
        "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n" +
        vtp_fields(described_) + "<Piece NumberOfPoints=\"" + std::to_string(point_count_) +
        "\" NumberOfVerts=\"0\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
        std::to_string(triangle_count_) + "\">\n";
    // In the order of the arrays: each element says where its own begins.
    if (!described_.normals.empty()) {
      xml += "<PointData Normals=\"normals\">\n";
      xml += arrays.element("Float32", "normals", 3, place_bytes);
      xml += "</PointData>\n";
    }
    if (!described_.pairs.empty()) {
      xml += "<CellData>\n";
      xml += arrays.element("Int64", "inside_outside", 2, sizeof(LabelPair) * triangle_count_);
      xml += "</CellData>\n";
    } else if (has_labels_) {
      xml += "<CellData Scalars=\"label\">\n";
      xml += arrays.element("Int64", "label", 1, sizeof(std::int64_t) * triangle_count_);
      xml += "</CellData>\n";
    }
    xml += "<Points>\n";
    xml += arrays.element("Float32", "points", 3, place_bytes);
    xml += "</Points>\n<Polys>\n";
    xml += arrays.element(number, "connectivity", 1, 3 * number_bytes() * triangle_count_);
    xml += arrays.element(number, "offsets", 1, number_bytes() * triangle_count_);
    xml += "</Polys>\n</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_";
    out_.text(xml);
  }

  void write_places(std::span<const MeshPoint> places) {
    out_.number(std::uint64_t{places.size_bytes()});
    for (const MeshPoint& place : places) out_.number(in_space(place, described_.space));
  }

  void write_labels() {
    if (!described_.pairs.empty()) {
      out_.number(std::uint64_t{described_.pairs.size_bytes()});
      for (const LabelPair& pair : described_.pairs) out_.number(pair);
    } else if (has_labels_) {
      out_.number(std::uint64_t{sizeof(std::int64_t) * triangle_count_});
      for (const MeshPart& part : described_.parts) {
        for (std::size_t i = part.begin; i < part.end; ++i) out_.number(*part.label);
      }
    }
  }

  template <class Number>
  void write_numbers() {
    out_.number(3 * number_bytes() * triangle_count_);
    for (const MeshTriangle& t : described_.mesh.triangles) {
      for (const std::uint32_t number : t) out_.number(static_cast<Number>(number));
    }
    out_.number(number_bytes() * triangle_count_);
    for (std::uint64_t i = 1; i <= triangle_count_; ++i) out_.number(static_cast<Number>(3 * i));
  }

  const MeshDescription& described_;
  std::uint64_t point_count_;
  std::uint64_t triangle_count_;
  bool has_labels_;
  bool is_wide_ = false;  // numbers of points and ends of triangles need 64 bits
  MeshBytes out_;
};

}  // namespace

void write_vtp(const MeshDescription& described, const Progress& watcher, PendingFile& file) {
  VtpWriter(described, watcher, file).write();
}

}  // namespace octavo
