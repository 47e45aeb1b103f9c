#include "octavo/mesh/formats/mesh_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/mesh/formats/mesh_readers.h"

namespace octavo {

namespace {

constexpr std::string_view kWordEnds = " \t\r\v\f";
/// Of polygons while their triangles are found.
constexpr std::uint64_t kCornerBytes = 80;
constexpr std::uint64_t kMostMeshPoints = std::numeric_limits<std::uint32_t>::max();

bool is_before(const MeshPoint& a, const MeshPoint& b) { return a < b; }

}  // namespace

void fail_mesh(const std::string& what, const std::string& where) {
  throw Error(ErrorKind::corrupt, where + ": " + what);
}

std::optional<MeshSpace> space_in(std::string_view text) {
  if (text.find("SPACE=RAS") != std::string_view::npos) return MeshSpace::ras;
  if (text.find("SPACE=LPS") != std::string_view::npos) return MeshSpace::lps;
  return std::nullopt;
}

bool MeshText::next_line() {
  if (rest_.empty()) return false;
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  line_ = rest_.substr(0, end);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  ++line_number_;
  return true;
}

std::string_view MeshText::word() {
  line_.remove_prefix(std::min(line_.find_first_not_of(kWordEnds), line_.size()));
  const std::string_view word = line_.substr(0, line_.find_first_of(kWordEnds));
  line_.remove_prefix(word.size());
  return word;
}

double MeshText::number() {
  const std::string_view text = word();
  if (const auto number = number_in_word(text)) return *number;
  fail_mesh(text.empty() ? "a number is missing" : escaped(text) + " is no number", where());
}

std::optional<double> number_in_word(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double number = 0;
  const auto end = std::from_chars(word.data(), word.data() + word.size(), number);
  // A number that no double holds is as good as infinite, or as 0.
  const bool is_number = end.ec == std::errc() || end.ec == std::errc::result_out_of_range;
  if (word.empty() || !is_number || end.ptr != word.data() + word.size()) return std::nullopt;
  return number;
}

void MeshGrowth::require_room(std::uint64_t bytes) const {
  if (bytes <= most_bytes_) return;
  throw Error(ErrorKind::limit_exceeded,
              "the mesh takes more than " + bytes_text(most_bytes_) + " of memory")
      .with_field("max_memory_bytes");
}

void MeshGrowth::add_point(double x, double y, double z) {
  const MeshPoint point = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  for (const float part : point) {
    if (!(std::abs(part) <= kFarthestPointMm)) {
      throw Error(ErrorKind::source_rejected,
                  "point " + count_text(static_cast<std::int64_t>(point_count() + 1)) +
                      " of the mesh has a coordinate of " + number_text(part) +
                      "; expected millimeters");
    }
  }
  if (point_count() == kMostMeshPoints) {
    throw Error(ErrorKind::limit_exceeded, "the mesh has 2^32 points or more");
  }
  // Growing, a list lies in memory twice.
  if (mesh_.points.size() == mesh_.points.capacity()) require_room(3 * mesh_.memory_bytes());
  mesh_.points.push_back(point);
}

void MeshGrowth::add_polygon(std::span<const std::uint32_t> corners) {
  const auto add = [&](const MeshTriangle& triangle) {
    if (mesh_.triangles.size() == mesh_.triangles.capacity()) {
      require_room(3 * mesh_.memory_bytes());
    }
    mesh_.triangles.push_back(triangle);
  };
  if (corners.size() == 3) {
    add({corners[0], corners[1], corners[2]});
    return;
  }
  require_room(mesh_.memory_bytes() + kCornerBytes * corners.size());
  for (const MeshTriangle& triangle : cutter_.cut(mesh_.points, corners)) add(triangle);
}

void MeshGrowth::weld() {
  std::vector<MeshPoint>& points = mesh_.points;
  require_room(mesh_.memory_bytes() + 8 * static_cast<std::uint64_t>(points.size()));
  for (MeshPoint& point : points) {
    for (float& part : point) part += 0.0f;  // -0 is 0
  }
  std::vector<std::uint32_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(i);
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return points[a] == points[b] ? a < b : is_before(points[a], points[b]);
  });

  // The first of those that are equal stands for all; numbers stay in the order of the file.
  std::vector<std::uint32_t> number(points.size());
  std::uint32_t first = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i == 0 || points[order[i]] != points[order[i - 1]]) first = order[i];
    number[order[i]] = first;
  }
  std::uint32_t kept = 0;
  for (std::size_t i = 0; i < number.size(); ++i) {
    if (number[i] != i) {
      number[i] = number[number[i]];
      continue;
    }
    points[kept] = points[i];
    number[i] = kept++;
  }
  points.resize(kept);
  for (MeshTriangle& triangle : mesh_.triangles) {
    for (std::uint32_t& corner : triangle) corner = number[corner];
  }
}

TriangleMesh MeshGrowth::take() {
  require_triangles(mesh_);
  return std::move(mesh_);
}

void require_triangles(const TriangleMesh& mesh) {
  if (mesh.triangles.empty()) {
    throw Error(ErrorKind::source_rejected, "the mesh has no triangles");
  }
}

bool is_mesh_readable(MeshFormat format) {
  return format == MeshFormat::stl || format == MeshFormat::ply || format == MeshFormat::obj;
}

const char* readable_mesh_endings() { return ".stl, .ply or .obj"; }

MeshReading read_mesh(ByteSpan bytes, MeshFormat format, std::uint64_t most_bytes) {
  switch (format) {
    case MeshFormat::stl: return read_stl(bytes, most_bytes);
    case MeshFormat::ply: return read_ply(bytes, most_bytes);
    default: return read_obj(bytes, most_bytes);
  }
}

void turn_to_lps(MeshReading& reading) {
  if (reading.space != MeshSpace::ras) return;
  for (MeshPoint& point : reading.mesh.points) {
    point[0] = -point[0];
    point[1] = -point[1];
  }
  reading.space = MeshSpace::lps;
}

}  // namespace octavo
