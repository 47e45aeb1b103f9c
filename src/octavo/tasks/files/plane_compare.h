// Compares two volumes plane by plane.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/planes/plane_source.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct Comparison {
  bool is_same_size = true;
  bool is_same_type = true;
  bool is_same_rescale = true;      ///< to the precision of a float, as NIfTI keeps it
  double shift_mm = 0;              ///< how far the two grids lie apart at most
  bool is_place_known = true;       ///< false: one of them does not know its spacing
  bool is_same_place = true;        ///< the shift is below a thousandth of a voxel
  bool is_real_units = false;       ///< voxels were compared as real values, not as stored
  bool is_by_digest = false;        ///< the digests that two files state were compared, no voxel
  std::int64_t voxels = 0;          ///< compared
  std::int64_t different = 0;
  std::int64_t nan_in_one = 0;      ///< of the different ones: NaN in one volume alone
  double max_difference = 0;        ///< of voxels that are no NaN, in the units that are compared
  double max_real_difference = 0;   ///< the same in real units
  Index3 first;                     ///< the first different voxel in z, y, x order
  std::array<double, 2> first_values{};
  /// Voxels of one value but of other bits, -0 and the payloads of NaN, where stored floats are
  /// compared without a tolerance.
  std::int64_t other_bits = 0;

  /// Geometry and voxels alike; number type and rescale may differ when the real values agree.
  bool is_equal() const { return is_same_size && is_same_place && different == 0; }
  /// Stored values alike as well.
  bool is_same_stored() const { return is_equal() && is_same_type && is_same_rescale; }
  /// The same bit by bit.
  bool is_same_data() const { return is_same_stored() && other_bits == 0; }
};

/// Compares everything but the voxels.
Comparison compare_grids(const VolumeDescription& a, const VolumeDescription& b);

/// What compare_planes finds of two files whose digests say that all voxels are the same, of one
/// type and rescale; none where voxels have to be read.
std::optional<Comparison> compare_digests(const FileReader& a, const FileReader& b);

/// A tolerance in real units as compare_planes takes it for these two volumes. It forgives what
/// the float32 of a slope that is not whole adds to a difference.
double tolerance_in_compared_units(const VolumeDescription& a, const VolumeDescription& b,
                                   double real);

/// What compare_planes takes, with what the sources hold.
std::uint64_t compare_memory_bytes(const PlaneSource& a, const PlaneSource& b);

/// Voxels count as different when they are more than `tolerance` apart. Sizes that differ end it at
/// once. When the rescales are the same stored values are compared, otherwise real ones;
/// `tolerance` is in the units that are compared.
/// Throws  what the sources throw; Error{cancelled}
/// Memory  compare_memory_bytes: two planes, and those as numbers, besides what the sources hold
Comparison compare_planes(PlaneSource& a, PlaneSource& b, double tolerance, Progress& progress);

/// The same within the memory of a task.
/// max_error       a tolerance in real units
/// decoding_bytes  that the sources take beside what they hold
/// Throws          as compare_planes; Error{limit_exceeded}
Comparison compare_sources(PlaneSource& a, PlaneSource& b, double max_error,
                           std::uint64_t decoding_bytes, const TaskContext& context);

}  // namespace octavo
