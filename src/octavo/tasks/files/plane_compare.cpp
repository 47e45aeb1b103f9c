#include "octavo/tasks/files/plane_compare.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "octavo/core/error.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/tasks/geometry_words.h"
#include "octavo/tasks/volume_facts.h"

namespace octavo {

namespace {

/// A source with the plane it gave last.
struct Side {
  PlaneSource& source;
  UnsetBytes plane;
  std::vector<double> values;  ///< once they were asked for

  explicit Side(PlaneSource& s) : source(s) {
    const VolumeDescription& d = s.description();
    plane.resize(static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
  }
};

bool is_same(const Rescale& a, const Rescale& b) {
  return static_cast<float>(a.slope) == static_cast<float>(b.slope) &&
         static_cast<float>(a.intercept) == static_cast<float>(b.intercept);
}

/// A slope that no format rounds.
bool is_whole(const Rescale& rescale) { return std::trunc(rescale.slope) == rescale.slope; }

/// The voxels as numbers; a double holds every value of every voxel type.
void fill_values(Side& side, bool real_units) {
  const VolumeDescription& d = side.source.description();
  with_voxel_type(d.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    side.values.resize(side.plane.size() / sizeof(T));
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

/// Voxels that are alike as values, but not bit by bit. Requires one type and values of both.
std::int64_t count_other_bits(const Side& a, const Side& b) {
  const auto bytes = static_cast<std::size_t>(bytes_per_voxel(a.source.description().type));
  std::int64_t count = 0;
  for (std::size_t i = 0; i < a.values.size(); ++i) {
    const std::byte* const at_a = a.plane.data() + i * bytes;
    const std::byte* const at_b = b.plane.data() + i * bytes;
    if (std::memcmp(at_a, at_b, bytes) != 0 && !is_different(a.values[i], b.values[i], 0)) ++count;
  }
  return count;
}

void compare_plane(Side& a, Side& b, std::int64_t z, double tolerance, Comparison& result) {
  if (!result.is_real_units && result.is_same_type &&
      std::ranges::equal(a.plane.bytes(), b.plane.bytes())) {
    return;
  }
  fill_values(a, result.is_real_units);
  fill_values(b, result.is_real_units);
  if (!result.is_real_units && result.is_same_type && tolerance == 0) {
    result.other_bits += count_other_bits(a, b);
  }
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
    if (std::isnan(distance)) ++result.nan_in_one;
  }
}

}  // namespace

Comparison compare_grids(const VolumeDescription& a, const VolumeDescription& b) {
  Comparison result;
  result.is_same_size = a.size == b.size;
  result.is_same_type = a.type == b.type;
  result.is_same_rescale = is_same(a.rescale, b.rescale);
  result.is_real_units = !result.is_same_rescale;
  if (!result.is_same_size) return result;
  result.shift_mm = largest_shift_mm(a.geometry, b.geometry, a.size);
  result.is_place_known = is_spacing_known(a) && is_spacing_known(b);
  result.is_same_place =
      !result.is_place_known || result.shift_mm <= shift_tolerance_mm(a.geometry);
  return result;
}

std::optional<Comparison> compare_digests(const FileReader& a, const FileReader& b) {
  Comparison result = compare_grids(a.description(), b.description());
  if (!result.is_same_size || !result.is_same_type || !result.is_same_rescale) return {};
  if (a.voxel_digest() != b.voxel_digest()) return {};
  result.is_by_digest = true;
  result.voxels = a.description().size.voxel_count();
  return result;
}

double tolerance_in_compared_units(const VolumeDescription& a, const VolumeDescription& b,
                                   double real) {
  // A slope of 0.1 is 1.5e-8 more as a float, and so is every difference of values that it scales.
  constexpr double kSlopeRounding = 1.2e-7;
  const double forgiving = is_whole(a.rescale) && is_whole(b.rescale) ? 0 : kSlopeRounding;
  const double tolerance = real * (1 + forgiving);
  if (!is_same(a.rescale, b.rescale) || a.rescale.slope == 0) return tolerance;
  return tolerance / std::abs(a.rescale.slope);
}

std::uint64_t compare_memory_bytes(const PlaneSource& a, const PlaneSource& b) {
  std::uint64_t bytes = 0;
  for (const PlaneSource* source : {&a, &b}) {
    const VolumeDescription& d = source->description();
    const auto voxels = static_cast<std::uint64_t>(d.size.x * d.size.y);
    bytes += source->resident_bytes() + plane_bytes(d) + voxels * sizeof(double);
  }
  return bytes;
}

Comparison compare_planes(PlaneSource& a, PlaneSource& b, double tolerance, Progress& progress) {
  const VolumeDescription& da = a.description();
  Comparison result = compare_grids(da, b.description());
  if (!result.is_same_size) return result;
  Side side_a(a);
  Side side_b(b);
  progress.begin("comparing", da.size.z, "planes");
  for (std::int64_t z = 0; z < da.size.z; ++z) {
    if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped on request");
    a.read_plane(side_a.plane.bytes());
    b.read_plane(side_b.plane.bytes());
    compare_plane(side_a, side_b, z, tolerance, result);
    result.voxels += da.size.x * da.size.y;
    progress.advance(1);
  }
  progress.end();
  const double unit = result.is_real_units ? 1 : std::abs(da.rescale.slope);
  result.max_real_difference = result.max_difference * unit;
  return result;
}

Comparison compare_sources(PlaneSource& a, PlaneSource& b, double max_error,
                           std::uint64_t decoding_bytes, const TaskContext& context) {
  context.require_memory(compare_memory_bytes(a, b) + decoding_bytes,
                         "comparing layers of planes");
  const double tolerance =
      tolerance_in_compared_units(a.description(), b.description(), max_error);
  return compare_planes(a, b, tolerance, context.watcher());
}

}  // namespace octavo
