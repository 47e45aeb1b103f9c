#include "common/plane_compare.h"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "octavo/core/error.h"
#include "octavo/tasks/geometry_words.h"
#include "text/quantities.h"
#include "text/volume_json.h"

namespace octavo::cli {

namespace {

/// A source with the plane it gave last.
struct Side {
  PlaneSource& source;
  std::vector<std::byte> plane;
  std::vector<double> values;

  explicit Side(PlaneSource& s) : source(s) {
    const VolumeDescription& d = s.description();
    plane.resize(static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
    values.resize(static_cast<std::size_t>(d.size.x * d.size.y));
  }
};

bool is_same(const Rescale& a, const Rescale& b) {
  return static_cast<float>(a.slope) == static_cast<float>(b.slope) &&
         static_cast<float>(a.intercept) == static_cast<float>(b.intercept);
}

/// The voxels as numbers; a double holds every value of every voxel type.
void fill_values(Side& side, bool real_units) {
  const VolumeDescription& d = side.source.description();
  with_voxel_type(d.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::size_t i = 0; i < side.values.size(); ++i) {
      T voxel;
      std::memcpy(&voxel, side.plane.data() + i * sizeof(T), sizeof(T));
      const auto stored = static_cast<double>(voxel);
      side.values[i] = real_units ? d.rescale.to_real(stored) : stored;
    }
  });
}

bool is_different(double a, double b, double tolerance) {
  if (std::isnan(a) || std::isnan(b)) return std::isnan(a) != std::isnan(b);
  return a != b && !(std::abs(a - b) <= tolerance);
}

void compare_plane(Side& a, Side& b, std::int64_t z, double tolerance, Comparison& result) {
  if (!result.is_real_units && result.is_same_type && a.plane == b.plane) return;
  fill_values(a, result.is_real_units);
  fill_values(b, result.is_real_units);
  const std::int64_t width = a.source.description().size.x;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const double distance = std::abs(a.values[i] - b.values[i]);
    if (distance > result.max_difference) result.max_difference = distance;
    if (!is_different(a.values[i], b.values[i], tolerance)) continue;
    if (result.different++ == 0) {
      const auto at = static_cast<std::int64_t>(i);
      result.first = {at % width, at / width, z};
      result.first_values = {a.values[i], b.values[i]};
    }
    if (std::isnan(distance)) result.max_difference = distance;
  }
}

}  // namespace

double compared_tolerance(const VolumeDescription& a, const VolumeDescription& b, double real) {
  constexpr double kDivisionRounding = 1e-12;
  if (!is_same(a.rescale, b.rescale) || a.rescale.slope == 0) return real;
  return real / std::abs(a.rescale.slope) * (1 + kDivisionRounding);
}

Comparison compare_volumes(PlaneSource& a, PlaneSource& b, double tolerance, Progress& progress) {
  const VolumeDescription& da = a.description();
  const VolumeDescription& db = b.description();
  Comparison result;
  result.is_same_size = da.size == db.size;
  result.is_same_type = da.type == db.type;
  result.is_same_rescale = is_same(da.rescale, db.rescale);
  result.is_real_units = !result.is_same_rescale;
  if (!result.is_same_size) return result;
  result.shift_mm = largest_shift_mm(da.geometry, db.geometry, da.size);
  result.is_place_known = is_spacing_known(metadata_of(da)) && is_spacing_known(metadata_of(db));
  result.is_same_place =
      !result.is_place_known || result.shift_mm <= shift_tolerance_mm(da.geometry);

  Side side_a(a);
  Side side_b(b);
  progress.begin("comparing", da.size.z, "planes");
  for (std::int64_t z = 0; z < da.size.z; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    a.read_plane(side_a.plane);
    b.read_plane(side_b.plane);
    compare_plane(side_a, side_b, z, tolerance, result);
    result.voxels += da.size.x * da.size.y;
    progress.advance(1);
  }
  progress.end();
  return result;
}

std::vector<std::string> comparison_lines(const Comparison& c, const VolumeDescription& a,
                                          const VolumeDescription& b) {
  if (!c.is_same_size) {
    return {fmt::format("size: {} against {} voxels", size_text(a.size), size_text(b.size))};
  }
  std::vector<std::string> lines;
  if (!c.is_same_place) {
    lines.push_back(fmt::format(
        "geometry: up to {} mm apart; origin {} against {} mm, spacing {} against {} mm",
        number_text(c.shift_mm), point_text(a.geometry.origin_mm, ", "),
        point_text(b.geometry.origin_mm, ", "), point_text(a.geometry.spacing_mm),
        point_text(b.geometry.spacing_mm)));
  }
  if (!c.is_same_rescale && c.different > 0) {
    lines.push_back(fmt::format("rescale: slope {}, intercept {} against slope {}, intercept {}",
                                number_text(a.rescale.slope), number_text(a.rescale.intercept),
                                number_text(b.rescale.slope), number_text(b.rescale.intercept)));
  }
  if (c.different > 0) {
    lines.push_back(fmt::format(
        "voxels: {} of {} differ, by at most {}; first at x,y,z = {},{},{}: {} against {}",
        count_text(c.different), count_text(c.voxels), number_text(c.max_difference), c.first.x,
        c.first.y, c.first.z, number_text(c.first_values[0]), number_text(c.first_values[1])));
  }
  return lines;
}

nlohmann::ordered_json comparison_json(const Comparison& c) {
  nlohmann::ordered_json object = {{"equal", c.is_equal()},
                                   {"same_size", c.is_same_size},
                                   {"same_type", c.is_same_type},
                                   {"same_rescale", c.is_same_rescale},
                                   {"same_geometry", c.is_same_size && c.is_same_place},
                                   {"geometry_known", c.is_place_known},
                                   {"shift_mm", nullptr},
                                   {"compared_as", c.is_real_units ? "real" : "stored"},
                                   {"voxels", c.voxels},
                                   {"different", c.different},
                                   {"max_difference", c.max_difference},
                                   {"first", nullptr}};
  if (c.is_place_known) object["shift_mm"] = c.shift_mm;
  if (c.different > 0) {
    object["first"] = {{"index", {c.first.x, c.first.y, c.first.z}}, {"values", c.first_values}};
  }
  return object;
}

}  // namespace octavo::cli
