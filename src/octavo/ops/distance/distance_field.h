// The distances of a whole mask, in as much memory as there is.
//
//     in memory     4 bytes a voxel
//     on disk       passes along x and y write planes to a scratch file; the pass along z reads
//                   so many rows of all planes, and writes them back; then planes are read
//     in a window   with a limit: planes as far away as the limit decide, no others are held
//
// All three give the same distances.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/ops/distance/distance_passes.h"

namespace octavo {

enum class DistanceHold : std::uint8_t { memory, disk, window };

/// How a field is held.
struct FieldPlan {
  DistanceHold hold = DistanceHold::memory;
  std::int64_t halo = 0;        ///< planes of a window on both sides
  std::int64_t slab = 64;       ///< planes that are asked for at once
  std::uint64_t bytes = 0;      ///< that it takes in memory
};

class DistanceField {
 public:
  virtual ~DistanceField() = default;
  /// Writes planes [begin, end) to `mm`. One thread at a time; uses those of the calling arena.
  /// Throws  Error{io}, Error{cancelled}
  virtual void read(std::int64_t begin, std::int64_t end, float* mm) = 0;
  /// The largest distance there is, either sign; nothing where planes are measured when read.
  virtual std::optional<double> largest_mm() const = 0;
};

/// The way that takes least time within `max_bytes`.
/// limit_mm   as for make_distance_field
/// max_bytes  what the field may take; a little more where rows or windows are larger
FieldPlan plan_distance_field(const Size3& size, const DistanceSettings& settings, double limit_mm,
                              std::uint64_t max_bytes);

/// The field of voxels; what they are filled from must outlive it.
/// limit_mm  distances beyond it become it; infinite: none do
/// storage   for a scratch file in `folder`, which vanishes with the field
/// Throws    Error{io}, Error{cancelled}
std::unique_ptr<DistanceField> make_distance_field(const InsideVoxels& voxels,
                                                   const DistanceSettings& settings,
                                                   double limit_mm, const FieldPlan& plan,
                                                   Storage& storage, const std::string& folder,
                                                   Progress& progress);

}  // namespace octavo
