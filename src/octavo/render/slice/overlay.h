// A second volume drawn over a section: where its labels end, or how high its values are.
//
//     kind        labels                         grey values
//     outline     a line along each border       -
//     wash        each label's color over all    colors from cold to hot over all
//     isolines    -                              lines of equal value, with the values on them
//
// The overlay has a grid of its own: each pixel is looked up where it lies in space, labels at the
// nearest voxel, grey values interpolated.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/label_names.h"
#include "octavo/file/reader.h"
#include "octavo/render/annotation.h"
#include "octavo/render/picture.h"
#include "octavo/render/slice/section.h"

namespace octavo {

enum class OverlayKind { outline, wash, isolines };

/// How an overlay is drawn; what is not set is chosen by the volume.
struct OverlayLook {
  std::optional<OverlayKind> kind;  ///< default: outline of labels, isolines of grey values
  /// Real units: the values of isolines; of a wash of grey values its two ends, below the lower of
  /// which nothing is drawn. Default: round values up to the highest of the volume.
  std::vector<double> levels;
  std::optional<double> opacity;  ///< 0 .. 1; default 1, of a wash 0.4
  std::optional<Color> color;     ///< one for all labels or lines
};

/// A volume and how it is drawn.
struct Overlay {
  std::shared_ptr<const FileReader> reader;
  OverlayLook look;
  LabelNames labels;
  std::optional<std::vector<std::int64_t>> kept;  ///< the labels that are drawn, sorted; else all
  std::string name;        ///< what the legend says of a mask
  bool is_named = false;   ///< whether it says it of isolines too
  std::string unit;        ///< of grey values
  std::size_t number = 0;  ///< chooses the color of a mask that has none
};

/// The same overlay with all that was left open decided. It serves any number of sections.
/// Throws Error{invalid_argument} on a kind that the volume does not go with, on levels that are
///        not finite, not in rising order or not two for a wash, on an opacity beyond 0 .. 1, and
///        what the reader throws
Overlay decided(Overlay overlay);

/// What stands for an overlay in the legend of a picture.
struct OverlayLegend {
  std::vector<LegendRow> rows;
  std::vector<Color> scale;  ///< of a wash of grey values, the lowest first
  std::array<std::string, 2> scale_ends;
  std::int64_t pixels = 0;  ///< that lie in the overlay's volume
  std::map<std::int64_t, std::int64_t> pixels_of_label;
};

/// The labels, that with the most pixels first.
std::vector<std::int64_t> largest_first(const std::map<std::int64_t, std::int64_t>& pixels);

/// Draws an overlay on the part of a picture that shows `section`, its pixel (0, 0) at `at`. Labels
/// that are seen become rows of the legend, the largest first.
/// overlay  as `decided` gives it
/// legend   of this overlay alone, in all sections of the picture
/// Runs on the threads of the calling task arena; throws what the reader throws.
/// Memory  about 10 bytes per pixel of the section
void draw_overlay(Picture& picture, const PixelArea& at, const PlaneSection& section,
                  const Overlay& overlay, OverlayLegend& legend);

}  // namespace octavo
