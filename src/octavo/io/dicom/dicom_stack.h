// A proven stack of slices and what each plane of the volume is made of: of one slice, or, where
// the user asked for it, of two slices, moved and interpolated.
//
// Every plane can be made on its own from at most two slices, so nothing but these is in memory.
// A plane at the height of a slice that is not moved holds that slice's stored voxels unchanged.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/warning.h"
#include "octavo/io/dicom/dicom_places.h"
#include "octavo/io/source_options.h"
#include "octavo/planes/plane_files.h"

namespace octavo {

/// What was done about missing and uneven slices.
struct GapRepair {
  GapPolicy policy = GapPolicy::error;  ///< error: nothing had to be done
  double left_out_mm = 0;               ///< behind the last plane, if it is worth a word
};

/// Slices in spatial order, and where they lie.
struct DicomStack {
  std::vector<DicomSlice> slices;
  std::vector<PlaneOrigin> planes;
  GapRepair gaps;
  std::optional<TiltRemoval> tilt;
  std::size_t dropped_duplicates = 0;
  bool leaves_out_empty = false;  ///< planes without a slice are empty, as in a segmentation
  bool holds_labels = false;   ///< nothing is interpolated: the nearest voxel counts
  std::optional<std::int64_t> padding;  ///< the stored value that takes part in no mixing
  Geometry geometry;
  bool spacing_known = false;  ///< as is the place; false: slices taken by their numbers
  std::vector<Warning> warnings;

  /// Size of the volume.
  Size3 size() const;
  /// Planes that are no slice of the source, by their interpolation or as background.
  std::int64_t made_plane_count() const;
};

/// Decides what the planes are made of, places them, and tells about it in `stack.warnings`.
/// Slices of other heights than an even stack has, and a tilt, are treated as the options say.
/// Requires at least two slices, sorted, at different heights.
/// Throws Error{source_rejected} naming both files and both numbers when an option is missing or
/// does not help.
void plan_planes(DicomStack& stack, const SlicePlaces& places, const SourceOptions& options);

/// The changes for the metadata; nothing when the slices are the planes.
std::optional<PreparedNote> preparation_note(const DicomStack& stack);

}  // namespace octavo
