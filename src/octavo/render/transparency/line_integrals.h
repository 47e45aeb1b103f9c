// What the voxels of a file give to the lines that run through them: the transparency shading of
// the thesis.
//
// The leaves of the condensed octree are visited once each, from the farthest to the nearest; a
// leaf adds its emission times its length to every line through it. Nothing is hidden altogether:
// in the straight sum everything shines through everything; the exponential average composites
// what is in front over what is behind.
//
// Invariants
//   A sum is the sum over the voxels of the line, exactly. An average is that of its voxels one
//   after another, within the rounding of 32-bit floating point.
// Consequences
//   The result does not depend on the number of threads.
//   Memory is that of the lines, about 50 bytes per 64^3 voxels, and 2 MiB per thread.
//
// Source  thesis 4.7, Fig. 4.5 and 4.6; the average is Levoy's
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/render/transparency/density_classes.h"
#include "octavo/render/transparency/voxel_lines.h"

namespace octavo {

/// What was visited on the way.
struct LineCounts {
  std::int64_t leaves = 0;          ///< of the condensed octree, each counted when it is visited
  std::int64_t decoded_bricks = 0;  ///< the others were settled by the index
};

/// What is looked at, and from where.
struct LineView {
  int level = 0;
  Direction along;          ///< the steps from the observer into the volume
  std::optional<Box> kept;  ///< samples of the level; what is outside counts as class 0
};

struct LineSums {
  VoxelLines lines;
  int channels = 1;
  std::vector<std::int64_t> sums;  ///< [v][u][channel]
  LineCounts counts;
};

/// The straight sum along the lines of one level of a file.
/// emission  [class][channel], of every class, what one voxel gives
/// channels  1 or 3
/// Runs on the threads of the calling task arena. Throws Error{invalid_argument} on a bad level,
/// direction or table, Error{cancelled}, and what the reader throws.
LineSums sum_along_lines(const FileReader& reader, const LineView& view,
                         const DensityClasses& classes, std::span<const std::int32_t> emission,
                         int channels, Progress& progress);

/// An entry of the transfer function: the color of a class, and which share of what is behind it
/// one voxel absorbs.
struct ClassTransfer {
  std::array<float, 3> color{};  ///< 0 .. 1
  float opacity = 0;             ///< 0 .. 1
};

/// Red, green, blue and the share of the background that is left.
using LineColor = std::array<float, 4>;

struct LineAverages {
  VoxelLines lines;
  std::vector<LineColor> colors;  ///< [v][u]
  LineCounts counts;
};

/// The exponential average: with each voxel, from the farthest to the nearest, what is behind loses
/// the share `opacity` and the voxel's color gains it.
/// transfer  of every class
/// Otherwise as sum_along_lines.
LineAverages average_along_lines(const FileReader& reader, const LineView& view,
                                 const DensityClasses& classes,
                                 std::span<const ClassTransfer> transfer, Progress& progress);

}  // namespace octavo
