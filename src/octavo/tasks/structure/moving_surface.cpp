#include "octavo/tasks/structure/moving_surface.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/core/vectors.h"
#include "octavo/file/storage/storage.h"
#include "octavo/mesh/formats/mesh_reader.h"
#include "octavo/ops/align/surface_points.h"
#include "octavo/tasks/inputs.h"

namespace octavo {

namespace {

constexpr std::uint64_t kMostFeatureBytes = std::uint64_t{1} << 30;
constexpr std::size_t kFewestFeatures = 30;  // fewer fit many surfaces
constexpr double kWeakestHold = 0.02;  // of lines of sight: two views 16 degrees apart
constexpr double kFarthestMm = 1e9;

Bytes feature_bytes(const std::string& path, const TaskContext& context) {
  const std::shared_ptr<const ByteSource> file = open_byte_source(local_storage(), path);
  if (file->size() > kMostFeatureBytes) {
    throw Error(ErrorKind::limit_exceeded, "is longer than 1 GiB", path);
  }
  context.require_memory(4 * file->size(), "the points");
  Bytes bytes(static_cast<std::size_t>(file->size()));
  file->read(0, bytes);
  return bytes;
}

std::optional<double> feature_number(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [stop, failure] = std::from_chars(word.data(), word.data() + word.size(), value);
  const bool is_whole = failure == std::errc() && stop == word.data() + word.size();
  return is_whole && std::abs(value) <= kFarthestMm ? std::optional(value) : std::nullopt;
}

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBetween = " \t\r,;";
  line = line.substr(0, line.find('#'));
  std::vector<std::string_view> words;
  for (std::size_t at = line.find_first_not_of(kBetween); at != std::string_view::npos;) {
    const std::size_t end = line.find_first_of(kBetween, at);
    words.push_back(line.substr(at, end - at));
    at = end == std::string_view::npos ? end : line.find_first_not_of(kBetween, end);
  }
  return words;
}

void add_row(const std::vector<double>& row, MovingFeatures& features) {
  const Point3 first = {row[0], row[1], row[2]};
  if (row.size() == 3) features.points.push_back(first);
  else features.lines.push_back({first, {row[3], row[4], row[5]}});
}

MovingFeatures read_rows(const std::string& path, const TaskContext& context) {
  const Bytes bytes = feature_bytes(path, context);
  std::string_view rest(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  MovingFeatures features;
  std::size_t columns = 0;
  bool may_be_names = true;
  for (std::int64_t line = 1; !rest.empty(); ++line) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    const std::vector<std::string_view> words = words_of(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
    if (words.empty()) continue;
    std::vector<double> row;
    for (const std::string_view word : words) {
      if (const auto number = feature_number(word)) row.push_back(*number);
    }
    if (row.empty() && std::exchange(may_be_names, false)) continue;
    may_be_names = false;
    if (columns == 0) columns = row.size();
    if (row.size() != words.size() || row.size() != columns || (columns != 3 && columns != 6)) {
      throw Error(ErrorKind::source_rejected,
                  fmt::format("line {} is no row of {} numbers", line,
                              columns == 3 || columns == 6 ? fmt::format("{}", columns)
                                                           : "three or six"),
                  path);
    }
    if (columns == 6 && std::equal(row.begin(), row.begin() + 3, row.begin() + 3)) {
      throw Error(ErrorKind::source_rejected,
                  fmt::format("line {} names one place twice, which is no line of sight", line),
                  path);
    }
    add_row(row, features);
  }
  return features;
}

MovingFeatures read_mesh_points(const std::string& path, MeshFormat format, std::int64_t count,
                                const TaskContext& context) {
  MeshReading reading;
  try {
    const Bytes bytes = feature_bytes(path, context);
    reading = format == MeshFormat::ply ? read_point_ply(bytes, kMostFeatureBytes)
                                        : read_mesh(bytes, format, kMostFeatureBytes);
  } catch (const Error& error) {
    throw error.with_path(path);
  }
  turn_to_lps(reading);
  MovingFeatures features;
  if (!reading.mesh.triangles.empty()) {
    features.points = surface_points(reading.mesh, count);
  } else {
    for (const MeshPoint& p : reading.mesh.points) features.points.push_back({p[0], p[1], p[2]});
  }
  return features;
}

/// The median of how far a few of the points have their nearest.
double spacing_of(const std::vector<Point3>& points) {
  const std::size_t asked = std::min<std::size_t>(points.size(), 200);
  std::vector<double> nearest(asked, HUGE_VAL);
  for (std::size_t i = 0; i < asked; ++i) {
    for (std::size_t j = 0; j < points.size(); ++j) {
      const Point3 apart = difference(points[i], points[j]);
      if (j != i) nearest[i] = std::min(nearest[i], dot(apart, apart));
    }
  }
  std::nth_element(nearest.begin(), nearest.begin() + static_cast<std::ptrdiff_t>(asked / 2),
                   nearest.end());
  return std::sqrt(nearest[asked / 2]);
}

void check_features(const MovingFeatures& features, const std::string& path) {
  const std::size_t count = features.points.size() + features.lines.size();
  if (count < kFewestFeatures) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("holds {} points or lines; a pose takes {} or more", count,
                            kFewestFeatures),
                path);
  }
  if (features.lines.empty() || middle_of(features.lines).hold >= kWeakestHold) return;
  throw Error(ErrorKind::invalid_argument,
              "its lines of sight run nearly alike and do not say how far away anything is; they "
              "have to come from two sides",
              path);
}

}  // namespace

bool is_moving_mask(const std::string& path) { return is_octavo_path(path); }

MovingFeatures read_features(const std::string& path, std::int64_t count,
                             const TaskContext& context) {
  const auto format = mesh_format_of(path);
  MovingFeatures features;
  if (format && is_mesh_readable(*format)) {
    features = read_mesh_points(path, *format, count, context);
  } else if (path.ends_with(".csv") || path.ends_with(".txt") || path.ends_with(".xyz")) {
    features = read_rows(path, context);
  } else {
    throw Error(ErrorKind::invalid_argument,
                "what is laid onto a mask is an .8vo file, a mesh (" +
                    std::string(readable_mesh_endings()) +
                    ") or rows of numbers (.csv, .txt or .xyz)",
                path);
  }
  features.points = spread_points(std::move(features.points), count);
  features.lines = spread_lines(std::move(features.lines), count);
  check_features(features, path);
  if (!features.points.empty()) features.spacing_mm = spacing_of(features.points);
  return features;
}

}  // namespace octavo
