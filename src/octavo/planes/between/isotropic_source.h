// In-between planes for thick slices: a source whose voxels are cubes.
//
// Planes are made along z alone, at the distance of the pixels; within a plane nothing changes.
//
//     slices      |-------------|-------------|        spacing z 3 mm, pixels of 1 mm
//     planes      |----|----|---|----|----|---|
//     from        0    0 1  0 1 1    1 2  1 2 2
//
// - The first plane is the first slice: the origin stays. A plane at a slice (within a thousandth
//   of the slice distance) holds its stored voxels unchanged; where the slice distance is a whole
//   number of pixels (within a thousandth) that is every slice.
// - The last plane is the last one that does not lie behind the last slice; a rest of less than a
//   pixel there holds no plane, and is reported.
// - Grey is mixed from two slices (linear) or four (cubic: Keys, a = -0.5, with slices beyond the
//   ends continued in a straight line) as mix_planes says. Linear stays between the two slices;
//   cubic may leave their range by up to an eighth of the largest difference between the four, and
//   is held within the voxel type.
// - Labels are interpolated by their shapes: shape_between.h. No label is made up.
//
// Source: thesis section 1.2; Keys, "Cubic convolution interpolation" (1981)
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "octavo/planes/plane_source.h"

namespace octavo {

enum class PlaneInterpolation { linear, cubic, shape };

/// "linear", "cubic", "shape".
const char* interpolation_name(PlaneInterpolation method);

/// What is to be done to make the voxels of a volume cubes.
struct IsotropicPlan {
  PlaneInterpolation method = PlaneInterpolation::linear;
  std::int64_t slices = 0;       ///< of the source
  std::int64_t planes = 0;       ///< to be made; `slices` when there is nothing to do
  std::int64_t made_planes = 0;  ///< of these not the voxels of a slice
  double slice_mm = 0;           ///< the slice distance of the source
  double plane_mm = 0;           ///< the plane distance to come
  std::int64_t steps = 0;        ///< planes a slice distance where they are a whole number, else 0
  double left_out_mm = 0;        ///< behind the last plane, up to the last slice
  std::string notice;            ///< what is done, or why there is nothing to do, for the user
  bool is_needed = false;
};

/// method  linear or cubic for grey, shape for labels
/// Throws  Error{invalid_argument} when the spacing is unknown, or labels are float32;
///         Error{source_rejected} when pixels are not square or slices lie more than 256 pixels
///         apart; Error{limit_exceeded} when the planes become too many
IsotropicPlan plan_isotropic(const VolumeDescription& description, PlaneInterpolation method);

/// The planes of `source` as planned for its description, which gets their number and distance and
/// a "prepared" entry "isotropic" in its metadata, where numbers of slices become those of planes.
/// Requires plan.is_needed.
/// Memory  two slices (linear), four (cubic), or two and ShapeBetween::memory_bytes (shape): part
///         of resident_bytes()
std::unique_ptr<PlaneSource> make_isotropic_source(std::unique_ptr<PlaneSource> source,
                                                   const IsotropicPlan& plan);

}  // namespace octavo
