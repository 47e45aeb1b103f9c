// Slices and oblique sections of a file as a picture for people.
//
// A picture shows one section, or slices side by side; over each, other volumes (overlay.h). What
// is written on it: position, window, spacing, scale bar, sides of the patient, legends.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/file/reader.h"
#include "octavo/render/picture.h"
#include "octavo/render/slice/overlay.h"
#include "octavo/render/slice/section.h"
#include "octavo/render/window.h"

namespace octavo {

/// What is written on a picture, and what is known to write.
struct SliceCaptions {
  bool has_scale_bar = true;
  bool has_sides = true;         ///< R L A P S I at the edges
  bool has_notes = true;         ///< position, window, spacing
  bool has_legend = true;        ///< of labels and overlays
  bool is_spacing_known = true;  ///< mm mean something
  bool is_place_known = true;    ///< so do the sides of the patient
  std::string unit;              ///< of grey values
};

struct SlicePictureOptions {
  int level = 0;
  int axis = 2;                       ///< index axis that slices lie across: 0 x, 1 y, 2 z
  std::vector<std::int64_t> indices;  ///< in samples of `level`; none: the middle one
  std::optional<CutPlane> plane;      ///< a section along it, in place of slices
  std::int64_t columns = 1;           ///< of slices side by side
  std::optional<Window> window;       ///< real units; default from what is drawn; not for labels
  std::int64_t minimum_side = 512;    ///< smaller pictures are enlarged by a whole number
  LabelNames labels;                  ///< of the file itself
  /// The labels of the file that are drawn, sorted; else all.
  std::optional<std::vector<std::int64_t>> kept_labels;
  std::vector<Overlay> overlays;      ///< as `decided` gives them, the lowest first
  SliceCaptions captions;
};

struct SlicePicture {
  Picture picture;                           ///< grey, or colors for labels and with overlays
  Window window;                             ///< the one used; meaningless for labels
  double pixel_mm = 1;                       ///< side of a pixel
  EdgeLetters letters;                       ///< the patient's sides at the edges
  std::optional<PixelMap> place;             ///< of pixels in mm (LPS); none of a montage
  std::vector<std::int64_t> indices;         ///< of the slices
  std::vector<std::int64_t> overlay_pixels;  ///< pixels that lie in each overlay's volume
  std::int64_t label_pixels = 0;             ///< pixels that lie in labels, of overlays too
};

/// Draws sections with square pixels, as fine as the finest spacing: grey values linearly
/// interpolated, labels never; what lies outside the volume is black. Only the bricks that a
/// section meets are read.
/// Runs on the threads of the calling task arena; the picture does not depend on how many.
/// Throws Error{invalid_argument} when axis, level, index, plane or window make no sense,
///        Error{limit_exceeded} above 2^28 pixels or kLongestPictureSide, what the readers throw
/// Memory  about 26 bytes per pixel
SlicePicture render_slice(const FileReader& reader, const SlicePictureOptions& options);

/// Pixels of the picture that render_slice would draw; throws as it does for options.
std::int64_t slice_pixels(const FileReader& reader, const SlicePictureOptions& options);

}  // namespace octavo
