// The values of a volume at the pixels of a section.
//
// The section is taken tile by tile; of each tile it is known which samples its pixels need, hence
// in which bricks they lie, and only those bricks are read. Within a brick the smallest box around
// the needed samples is taken.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/render/slice/section.h"

namespace octavo {

enum class SampleInterpolation { linear, nearest };

/// Stored values at the pixels of a section.
struct SectionSamples {
  std::int64_t width = 0;
  std::int64_t height = 0;
  std::vector<double> values;  ///< [y][x]; NaN outside the volume
  std::int64_t pixels_inside = 0;

  double at(std::int64_t x, std::int64_t y) const {
    return values[static_cast<std::size_t>(y * width + x)];
  }
};

/// Reads one level of a volume at the pixels of `section`. A pixel is inside when it lies in the
/// box of the volume's voxels; between the centers of voxels values are interpolated, beside NaN
/// and infinities the nearest voxel counts, beyond the outermost they stay the same. Which voxel is
/// nearest says core/nearest_voxel.h.
/// Runs on the threads of the calling task arena; the result does not depend on how many. Throws
/// Error{invalid_argument} when there is no such level, and what the reader throws.
/// Memory  8 bytes per pixel, and for each thread the samples of a tile of 64 x 64 pixels
SectionSamples sample_section(const FileReader& reader, int level, const PlaneSection& section,
                              SampleInterpolation interpolation);

/// Turns the stored values of a section into real ones.
void to_real(SectionSamples& samples, const Rescale& rescale);

/// Makes background of every label but those of `kept`, which are sorted.
void keep_labels(SectionSamples& samples, const std::vector<std::int64_t>& kept);

/// The coarsest level whose spacing is nowhere coarser than `pixel_mm`; 0 where none is as fine.
int level_for_pixels(const FileReader& reader, double pixel_mm);

}  // namespace octavo
