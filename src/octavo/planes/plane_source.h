// Where planes come from. Geometry, type and metadata are known before the first plane is asked
// for.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/volume.h"
#include "octavo/core/warning.h"
#include "octavo/planes/plane_files.h"

namespace octavo {

/// A volume delivered plane by plane, z = 0 first unless another one is sought. One thread at a
/// time.
class PlaneSource {
 public:
  virtual ~PlaneSource() = default;

  /// kind is `labels` only when the source itself says so (e.g. a segmentation).
  virtual const VolumeDescription& description() const = 0;

  /// Things the user should know that do not stop the import ("spacing is not in the files: 1 mm
  /// assumed").
  virtual const std::vector<Warning>& warnings() const = 0;

  /// Fills `plane` ([y][x], size.x * size.y voxels of the type, native byte order) with the next
  /// plane.
  /// Throws Error{source_rejected} naming the file, or Error{io}; Error{invalid_argument} where no
  ///        plane is left.
  virtual void read_plane(std::span<std::byte> plane) = 0;

  /// Makes plane `first` the next one. None from `end` on will be asked for: who reads ahead stops
  /// there. Planes are the same from wherever they are sought.
  /// Throws Error{invalid_argument} unless 0 <= first <= end <= size.z; what reading throws where
  ///        planes are passed by reading
  virtual void seek(std::int64_t first, std::int64_t end) = 0;

  /// Whether `seek` reads nothing of the planes that it passes. Otherwise it reads those between
  /// the next one and the one sought, or, backwards, all before that one.
  virtual bool can_seek() const { return true; }

  /// Bytes the source holds in memory; 0 where it reads one plane after the other.
  virtual std::uint64_t resident_bytes() const { return 0; }

  /// The files that voxels come from; none for voxels that are computed or in memory. Known before
  /// the first plane; who wraps another source passes its files on.
  virtual const PlaneFiles& files() const {
    static const PlaneFiles kNone;
    return kNone;
  }
};

}  // namespace octavo
