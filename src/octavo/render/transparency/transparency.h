// Transparency shading: what lies inside a volume shines through what lies around it.
//
// The lines of voxels along one of 26 directions are summed or averaged (line_integrals.h); each
// is one point of a lattice, which is then drawn on a picture as a view has it: square pixels,
// voxels true in size, a slanted look foreshortened as it is.
//
// Source  thesis 4.7, Fig. 4.5 and 4.6
#pragma once

#include <optional>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/render/picture.h"
#include "octavo/render/transparency/density_classes.h"
#include "octavo/render/transparency/line_integrals.h"
#include "octavo/render/view.h"
#include "octavo/render/window.h"

namespace octavo {

/// One of the 26 directions, and how far it is from the one asked for.
struct NearestLines {
  Direction toward;  ///< steps along the index axes from the object to the viewer
  double degrees = 0;
};

/// The direction of voxel lines that is nearest to a unit vector in world space.
NearestLines nearest_lines(const Geometry& geometry, const Point3& toward);

/// Grey values between two, stored units: the one that stands for the lower real value gives
/// nothing, the other the most.
struct ValueRamp {
  double low = 0;
  double high = 1;  ///< below `low` where the rescale falls
};

/// The ramp from the 0.5th percentile of a volume to the 99.5th, taken from a level of at most 2^21
/// samples. When `is_open` it ends at the maximum value, or its bound, where the index knows one.
ValueRamp robust_ramp(const FileReader& reader, bool is_open);

/// Ranges in HU that let bone be seen through skin: fat and soft tissue faint and warm, bone dense.
/// finest_mm  spacing of the finest axis
std::vector<DensityRange> hounsfield_ranges(double finest_mm, bool is_average);

struct TransparencyOptions {
  int level = 0;
  std::optional<Box> kept;           ///< samples of the level; what is outside is not drawn
  bool is_average = false;           ///< exponential averaging in place of the straight sum
  std::vector<DensityRange> ranges;  ///< none: grey, by the ramp
  ValueRamp ramp;
  double ramp_opacity = 0.05;  ///< of its high end in an average
  /// Which sums are black and white. Without ranges in real units above that of ramp.low times mm;
  /// with ranges in opacity times the finest spacing. Default: from the sums that are not 0, and
  /// where these are all one from 0 to it.
  std::optional<Window> window;
  Color background{0, 0, 0};
};

struct TransparencyPicture {
  Picture picture;  ///< of three channels
  Window window;    ///< the one used; meaningless for an average
  LineCounts counts;
  bool is_lit = false;   ///< some voxel gives light; of averages, hides some
  bool is_seen = false;  ///< some light is above the window's black; of averages as is_lit
};

/// Draws one level of a grey volume. `view` is of that level and looks along lines of voxels. Sums
/// without ranges hide the background as a film does; colors and averages are light upon it.
/// Runs on the threads of the calling task arena; the picture does not depend on how many.
/// Throws Error{invalid_argument} when the view is of another grid or does not look along one of
/// the 26 directions, or the ramp or a window has no width; and what sum_along_lines throws.
/// Memory  up to 48 bytes per line of voxels and 3 per pixel, besides that of line_integrals.h
TransparencyPicture render_transparency(const FileReader& reader, const View& view,
                                        const TransparencyOptions& options, Progress& progress);

}  // namespace octavo
