// Voxels out of numbers of 64 bits.
//
// A voxel has 32 bits at most, and the type of a volume is known before its first plane. So the
// first planes choose it, and every value that follows must fit:
//
//     int64, uint64        int32 or uint32, whichever holds the values; else that of the same sign
//     float64, all whole   the same
//     float64, else        float32: exactly where all of these values are float32 numbers, else
//                          rounded to the nearest one
//
// Planes of a single value tell little, as an empty border does: of the others, 32 are looked at.
// So many show the steps of a volume that was interpolated along z between whole numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "octavo/io/source/stored_type.h"

namespace octavo {

/// How the wide numbers of one source become voxels.
struct Narrowing {
  WideType from = WideType::float64;
  VoxelType to = VoxelType::float32;  ///< int32, uint32 or float32
  bool rounds = false;                ///< float64 to float32: to the nearest

  bool operator==(const Narrowing&) const = default;
};

/// Fills `plane` with plane z, wide numbers in native byte order.
using WidePlaneReader = std::function<void(std::int64_t z, std::span<std::byte> plane)>;

/// Chooses how the planes that `read` gives become voxels; they are asked for from 0 on, one after
/// the other. Values that nothing holds are left to narrow().
/// Throws as `read`; Error{source_rejected}, without a path, where all of these values lie so near
///        to 0 that float32 has few numbers for them, or none
/// Memory one plane
Narrowing choose_narrowing(WideType from, std::int64_t plane_count, std::uint64_t plane_bytes,
                           const WidePlaneReader& read);

/// Tells by how much float64 voxels change where they become float32.
std::string float_rounding_warning();

/// Where a run of voxels lies, for messages.
struct RunPlace {
  const std::string& path;
  std::int64_t columns = 1;
  std::int64_t z = 0;
  std::int64_t first = 0;  ///< of the run in its plane
};

/// Turns wide numbers into voxels of narrowing.to; NaN and infinities stay what they are, -0 and
/// what rounds to it become 0.
/// Requires as many voxels as numbers. Thread-safe.
/// Throws Error{source_rejected} with the first value that does not fit and its place
void narrow(const Narrowing& narrowing, std::span<const std::byte> wide,
            std::span<std::byte> voxels, const RunPlace& place);

}  // namespace octavo
