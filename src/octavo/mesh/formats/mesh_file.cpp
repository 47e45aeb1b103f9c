#include "octavo/mesh/formats/mesh_file.h"

#include <bit>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <limits>

#include "octavo/core/bytes.h"
#include "octavo/core/error.h"
#include "octavo/mesh/point_distance.h"

namespace octavo {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are written as they are");

/// Appends small pieces to a file, a megabyte at a time.
class MeshBytes {
 public:
  explicit MeshBytes(PendingFile& file) : file_(file) { buffer_.reserve(kBytes); }

  template <class T>
  void number(T value) {
    raw(&value, sizeof value);
  }
  void text(std::string_view text) { raw(text.data(), text.size()); }
  /// The shortest digits that read back as the same number.
  template <class T>
  void digits(T value) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, value);
    raw(digits, static_cast<std::size_t>(end.ptr - digits));
  }
  void flush() {
    if (!buffer_.empty()) file_.append(buffer_);
    buffer_.clear();
  }

 private:
  static constexpr std::size_t kBytes = 1 << 20;

  void raw(const void* data, std::size_t size) {
    if (buffer_.size() + size > kBytes) flush();
    const auto* bytes = static_cast<const std::uint8_t*>(data);
    buffer_.insert(buffer_.end(), bytes, bytes + size);
  }

  PendingFile& file_;
  Bytes buffer_;
};

MeshPoint in_space(const MeshPoint& point, MeshSpace space) {
  if (space == MeshSpace::lps) return point;
  // Not the negative, which is -0 for 0.
  return {0 - point[0], 0 - point[1], point[2]};
}

std::string space_name(MeshSpace space) { return space == MeshSpace::lps ? "LPS" : "RAS"; }

void require_countable(std::uint64_t count, std::uint64_t most, const char* what,
                       const PendingFile& file) {
  if (count <= most) return;
  throw Error(ErrorKind::limit_exceeded,
              std::to_string(count) + " " + what + "; the format numbers " + std::to_string(most),
              file.path());
}

MeshPoint normal_of(const MeshPoint& a, const MeshPoint& b, const MeshPoint& c) {
  const Point3 normal = cross(difference(place_of_point(b), place_of_point(a)),
                              difference(place_of_point(c), place_of_point(a)));
  const double length = std::sqrt(dot(normal, normal));
  if (!(length > 0)) return {0, 0, 0};
  return {static_cast<float>(normal[0] / length), static_cast<float>(normal[1] / length),
          static_cast<float>(normal[2] / length)};
}

void write_stl(const TriangleMesh& mesh, MeshSpace space, PendingFile& file) {
  constexpr std::size_t kHeaderBytes = 80;
  require_countable(mesh.triangles.size(), std::numeric_limits<std::uint32_t>::max(), "triangles",
                    file);
  MeshBytes out(file);
  // A header that begins with "solid" would be taken for text.
  std::string header = "octavo binary STL SPACE=" + space_name(space) + " UNIT=mm";
  header.resize(kHeaderBytes, ' ');
  out.text(header);
  out.number(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const MeshTriangle& t : mesh.triangles) {
    const MeshPoint a = in_space(mesh.points[t[0]], space);
    const MeshPoint b = in_space(mesh.points[t[1]], space);
    const MeshPoint c = in_space(mesh.points[t[2]], space);
    for (const MeshPoint& p : {normal_of(a, b, c), a, b, c}) out.number(p);
    out.number(std::uint16_t{0});
  }
  out.flush();
}

void write_ply(const TriangleMesh& mesh, MeshSpace space, const std::vector<std::string>& comments,
               PendingFile& file) {
  require_countable(mesh.points.size(), std::numeric_limits<std::int32_t>::max(), "points", file);
  MeshBytes out(file);
  std::string header = "ply\nformat binary_little_endian 1.0\n";
  for (const std::string& comment : comments) header += "comment " + comment + "\n";
  header += "comment SPACE=" + space_name(space) + " UNIT=mm\nelement vertex " +
            std::to_string(mesh.points.size()) +
            "\nproperty float x\nproperty float y\nproperty float z\nelement face " +
            std::to_string(mesh.triangles.size()) +
            "\nproperty list uchar int vertex_indices\nend_header\n";
  out.text(header);
  for (const MeshPoint& point : mesh.points) out.number(in_space(point, space));
  for (const MeshTriangle& t : mesh.triangles) {
    out.number(std::uint8_t{3});
    out.number(t);
  }
  out.flush();
}

void write_obj(const TriangleMesh& mesh, MeshSpace space, const std::vector<std::string>& comments,
               PendingFile& file) {
  MeshBytes out(file);
  for (const std::string& comment : comments) out.text("# " + comment + "\n");
  out.text("# SPACE=" + space_name(space) + " UNIT=mm\n");
  for (const MeshPoint& point : mesh.points) {
    out.text("v");
    for (const float value : in_space(point, space)) {
      out.text(" ");
      out.digits(value);
    }
    out.text("\n");
  }
  for (const MeshTriangle& t : mesh.triangles) {
    out.text("f");
    for (const std::uint32_t number : t) {
      out.text(" ");
      out.digits(std::uint64_t{number} + 1);
    }
    out.text("\n");
  }
  out.flush();
}

}  // namespace

std::optional<MeshFormat> mesh_format_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension();
  for (char& letter : ending) {
    letter = static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  if (ending == ".stl") return MeshFormat::stl;
  if (ending == ".ply") return MeshFormat::ply;
  if (ending == ".obj") return MeshFormat::obj;
  return std::nullopt;
}

const char* mesh_format_endings() { return ".stl, .ply or .obj"; }

void write_mesh(const TriangleMesh& mesh, MeshFormat format, MeshSpace space,
                const std::vector<std::string>& comments, PendingFile& file) {
  switch (format) {
    case MeshFormat::stl: write_stl(mesh, space, file); break;
    case MeshFormat::ply: write_ply(mesh, space, comments, file); break;
    case MeshFormat::obj: write_obj(mesh, space, comments, file); break;
  }
}

}  // namespace octavo
