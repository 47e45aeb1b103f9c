// Lines along which a field of samples has one value: marching squares, joined into long lines.
//
//     a---b    a side of a cell of four samples is crossed where one of its ends is below the level
//     | / |    and the other is not, at the place where linear interpolation has the level. Two
//     c---d    crossings are joined; of four, those around a corner that differs from the mean.
//
// Consequences
//   Samples on the two sides of a line differ in being below the level, for every level.
//   A line ends only at the border of the field or beside a sample that is not a number.
#pragma once

#include <span>
#include <vector>

#include "octavo/render/slice/section_samples.h"
#include "octavo/render/stroke.h"

namespace octavo {

/// A line in pixels; closed where its first point is its last.
using Isoline = std::vector<PixelPoint>;

/// All lines of a level. Points lie on the sides of cells.
/// Memory  about 50 bytes per crossed side
std::vector<Isoline> isolines(const SectionSamples& field, double level);

/// Levels at round distances for values between two: at most `maximum_count`, each inside.
std::vector<double> round_levels(double low, double high, int maximum_count);

}  // namespace octavo
