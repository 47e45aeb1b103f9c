// What a user may say about a source: how to read it, what to take of it, what to repair.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/io/source/stored_type.h"
#include "octavo/planes/plane_files.h"

namespace octavo {

struct RawLayout {
  Size3 size;
  StoredType type = VoxelType::uint8;
  bool big_endian = false;
  std::uint64_t header_bytes = 0;
};

/// Parses "nx,ny,nz,type" (type may end in ":be"). Throws Error{invalid_argument}.
RawLayout parse_raw_layout(const std::string& text);

/// What happens where slices of a series are missing or lie unevenly.
enum class GapPolicy {
  error,     ///< the series is rejected
  fill,      ///< planes missing on an even grid are interpolated between their neighbors
  ignore,    ///< a stack of numbered files is taken as it is
  resample,  ///< planes at the smallest regular step are interpolated along the normal
};

struct SourceOptions {
  std::optional<RawLayout> raw;  ///< the paths are headerless planes (one file, or one per plane)
  std::optional<Point3> spacing_mm;       ///< overrides, or supplies what the files lack
  std::string series;                     ///< of several: DICOM's UID, or the number in one TIFF
  GapPolicy on_gap = GapPolicy::error;    ///< ignore: TIFF and PNG stacks; the others: DICOM
  bool drop_duplicates = false;           ///< DICOM: of equal slices at one place one is taken
  bool untilt = false;                    ///< DICOM: slices sheared by a tilt are put upright
  std::string segment;  ///< DICOM SEG: the number or the label of the segment that is taken
  std::string channel;  ///< a number from 0 or a name, where a voxel has several values
  std::optional<std::int64_t> time;  ///< from 0, where there are several volumes in time
  bool keep_identity = false;             ///< names, dates, free text enter the metadata
  std::uint64_t max_memory_bytes = 0;     ///< of a process that opens the source; 0: no limit
  int threads = 1;  ///< that may unpack what a plane is made of, where that is several pieces
  /// The paths are slices, in their order, of a stack that was proven when all of it was open: how
  /// they become planes. Nothing is asked that only a whole stack tells; the description is that of
  /// the type and the size alone.
  std::optional<SliceOutline> excerpt = {};

  /// Asked between the planes that are read before the source is open, and while compressed files
  /// are read; may be empty.
  std::function<bool()> is_cancelled;

  /// The field of the first option set here that only DICOM sources understand; or nothing.
  std::string dicom_option() const;
};

}  // namespace octavo
