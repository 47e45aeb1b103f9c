// The nearest voxel of the other class, of a whole mask: in memory, or in a scratch file as
// distance_field.h draws it.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/ops/distance/distance_passes.h"
#include "octavo/ops/distance/site_lines.h"

namespace octavo {

class SiteField {
 public:
  virtual ~SiteField() = default;
  /// Writes the sites of planes [begin, end), [z][y][x]. One thread at a time.
  /// Throws  Error{io}
  virtual void read(std::int64_t begin, std::int64_t end, NearestSite* sites) const = 0;
};

/// The field of voxels of both classes; one axis has no more than 32767.
/// max_bytes  what it may take in memory: 8 bytes a voxel, or beyond that a scratch file of as much
///            in `folder`, which vanishes with the field; a plane and a row of all planes at least
/// Uses the threads of the calling task arena.
/// Throws     Error{limit_exceeded} for a longer axis, Error{io}, Error{cancelled}
std::unique_ptr<SiteField> make_site_field(const InsideVoxels& voxels, const Point3& spacing_mm,
                                           std::uint64_t max_bytes, Storage& storage,
                                           const std::string& folder, Progress& progress);

}  // namespace octavo
