// Masks as cubes: every leaf with its visible faces in three shades.
#pragma once

#include <span>

#include "octavo/octree/mask_tree.h"
#include "octavo/render/picture.h"
#include "octavo/render/view.h"

namespace octavo {

/// A mask and the color of its cubes where light falls on them straight.
struct PaintedMask {
  const MaskTree* tree = nullptr;
  Color color{};
};

struct CubeStyle {
  Color background{};
  /// How much darker a face is at the far end of `shown` than at the near one, 0 .. 1.
  double fade = 0.5;
  Box shown;
  /// Cubes thinner than a pixel take the pixels along their middle, also where they hold the center
  /// of none, but none whose center a cube of their own mask holds. Then the leaves of a shell may
  /// differ from all leaves in pixels at outlines.
  bool keeps_thin = false;
};

/// Darkens what is far.
class DepthFade {
 public:
  DepthFade(const View& view, const CubeStyle& style);

  /// 0 at the far end of what is shown, 1 at the near one.
  double nearness(double depth) const;
  /// The share of its brightness that a place keeps.
  double brightness(double nearness) const { return 1 - fade_ + nearness * fade_; }

 private:
  double farthest_ = 0;
  double per_depth_ = 0;
  double fade_ = 0;
};

/// Draws the leaves of masks from the farthest to the nearest: three channels. The masks lie on
/// the grid of the view and do not overlap. Uses the threads of the calling task arena; the picture
/// does not depend on their number.
/// Memory  64 rows of 4 bytes per pixel for each thread, beside the picture; up to 44 with spines
/// Source  thesis 4.3
Picture draw_cubes(std::span<const PaintedMask> masks, const View& view, const CubeStyle& style);

/// The same picture pixel for pixel, drawn from the nearest leaf to the farthest: cubes that lie
/// behind what is drawn already are not entered. Several times faster where much is hidden.
Picture draw_nearest_cubes(std::span<const PaintedMask> masks, const View& view,
                           const CubeStyle& style);

}  // namespace octavo
