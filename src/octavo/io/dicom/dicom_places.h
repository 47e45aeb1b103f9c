// Where the slices of a series lie: heights along their normal, shifts sideways, what is uneven.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/io/dicom/dicom_slice.h"

namespace octavo {

/// Unit vectors along rows and columns, and their normal.
struct SliceAxes {
  Point3 row;
  Point3 column;
  Point3 normal;
};

/// Requires an orientation. Throws Error{source_rejected} unless its vectors are perpendicular and
/// of length 1.
SliceAxes slice_axes(const DicomSlice& slice);

/// The places of slices sorted along the normal, relative to the first of them.
struct SlicePlaces {
  SliceAxes axes;
  std::vector<double> height_mm;                ///< along the normal, ascending from 0
  std::vector<std::array<double, 2>> shift_mm;  ///< within the plane, along rows and columns

  std::size_t count() const { return height_mm.size(); }
  double step_mm(std::size_t i) const { return height_mm[i] - height_mm[i - 1]; }
};

/// Sorts the slices along the normal; those of one height keep their order. All need a position.
/// Throws Error{source_rejected} as slice_axes, and when two lie more than 10 km apart.
SlicePlaces sort_along_normal(std::vector<DicomSlice>& slices);

/// A length may differ by a thousandth, or by 0.01 mm where that is little beside it.
double tolerance_mm(double step_mm);

/// A height difference up to which two slices lie at the same height.
double same_height_mm(const SlicePlaces& places);

/// Names a step that differs from the usual one and both numbers; empty when all are even.
/// Requires two slices at different heights.
std::string find_uneven_step(const std::vector<DicomSlice>& slices, const SlicePlaces& places);

/// The step of the even grid on which all slices lie when some are missing; nothing when they do
/// not. Requires no two slices at one height.
std::optional<double> grid_step_mm(const SlicePlaces& places);

/// The step of the even grid of about `stated_mm` on which all slices lie; nothing when they do
/// not. Requires no two slices at one height.
std::optional<double> grid_step_near_mm(const SlicePlaces& places, double stated_mm);

/// The smallest step that a tenth of all steps share, and at least two; the usual step where there
/// is none such. Requires at least two slices.
double smallest_regular_step_mm(const SlicePlaces& places);

/// The angle by which the stack leans from its normal; 0 within the tolerance.
double tilt_degrees(const SlicePlaces& places);

/// Names two slices between which the picture jumps sideways out of the line of the stack; empty
/// when they follow it.
std::string find_sideways_jump(const std::vector<DicomSlice>& slices, const SlicePlaces& places);

/// "4.22 mm".
std::string mm_text(double mm);

}  // namespace octavo
