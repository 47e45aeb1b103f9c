// Slices and oblique sections as PNG pictures, with other volumes drawn over them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/option_words.h"
#include "octavo/render/slice/slice_picture.h"
#include "octavo/tasks/asked_labels.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/pictures/picture_files.h"
#include "octavo/tasks/salvage.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

constexpr auto option_words(OverlayKind) {
  return in_order<OverlayKind>("outline", "wash", "isolines");
}

/// A plane through world space; without a point through the middle of the volume.
struct AskedPlane {
  std::optional<Point3> point_mm;
  Point3 normal{};
};

/// Several slices in one picture.
struct AskedMontage {
  std::optional<std::int64_t> columns{};  ///< both or none: as many as `every` gives
  std::optional<std::int64_t> rows{};
  std::optional<std::int64_t> every{};  ///< slices from one to the next; none: spread evenly
};

/// A volume to be drawn over the slices.
struct AskedOverlay {
  std::string path;  ///< an .8vo file or a URL of one
  OverlayLook look;
};

struct SliceOptions {
  std::string input;  ///< an .8vo file or a URL of one
  /// Ends in .png. Several axes write NAME-x.png, NAME-y.png and NAME-z.png.
  Output output;
  PictureListener on_picture = {};  ///< takes the pictures in place of the output
  std::vector<int> axes = {2};  ///< 0 x, 1 y, 2 z
  int level = 0;
  std::optional<std::int64_t> index;  ///< in samples of the level; default the middle
  std::optional<double> position_mm;  ///< in place of an index: along the axis of the body, LPS
  std::optional<AskedPlane> plane;    ///< in place of slices
  std::optional<AskedMontage> montage;
  std::optional<Window> window;  ///< real units; default from what is drawn
  std::string window_preset;     ///< in place of it: one of window_presets, for HU alone
  std::int64_t minimum_side = SlicePictureOptions{}.minimum_side;
  std::vector<AskedOverlay> overlays;  ///< the lowest first
  std::vector<double> overlay_levels;  ///< of those of grey values that have none of their own
  /// Only these labels, with none all: of the file, or where it holds grey values of the label maps
  /// over it, in each of which a name may be missing.
  AskedLabels labels;
  bool has_scale_bar = true;
  bool has_sides = true;
  bool has_notes = true;  ///< position, window, spacing
  bool has_legend = true;
  std::optional<SalvageFilling> salvage;  ///< of the input, not of overlays
};

/// One picture that was written.
struct DrawnSlice {
  std::string path;
  std::optional<int> axis;            ///< none: an oblique section
  std::vector<std::int64_t> indices;  ///< of its slices
  std::optional<CutPlane> plane;
  std::optional<PixelMap> place;  ///< of pixels in mm (LPS), as of `pixel_mm`; none of a montage
  std::int64_t width = 0;
  std::int64_t height = 0;
  double pixel_mm = 1;           ///< where the spacing is known; otherwise as if voxels were 1 mm
  std::optional<Window> window;  ///< none for labels
};

struct SliceResult {
  VolumeDescription volume;
  Geometry geometry;  ///< of the level
  int level = 0;
  std::vector<DrawnSlice> pictures;
  std::optional<SalvageReport> salvaged;
};

/// Draws all pictures before the first is written. Warns of damaged bricks that were filled, of
/// overlays whose spacing is not known, and of overlays and labels asked for that no picture meets.
/// Throws  as open_volume, require_free, salvaging and render_slice; Error{invalid_argument} when
///         options do not go together or with the volume
/// Memory  about 26 bytes per pixel, besides the reader's cache
SliceResult slice(const SliceOptions& options, const TaskContext& context);

}  // namespace octavo
