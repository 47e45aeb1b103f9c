// A geometry in words, and whether two of them are the same.
#pragma once

#include <string>

#include "octavo/core/box.h"
#include "octavo/core/volume.h"

namespace octavo {

/// "axial slices; x runs right to left, y front to back, z feet to head", with "(tilted 4.1
/// degrees)" when no axis of the body is met exactly.
std::string orientation_words(const Geometry& geometry);

/// Edge lengths of the volume in mm, voxels taken as boxes.
Point3 field_of_view_mm(const Geometry& geometry, const Size3& size);

/// A box in mm of world space.
struct BoxMm {
  Point3 lo;
  Point3 hi;
};

/// The world box around the voxels of `box`, from outer face to outer face.
BoxMm world_box(const Box& box, const Geometry& geometry);

/// "-200.9:199.1,-59.4:340.6,-680.3:-405.3", the world box around all voxels.
std::string extent_text(const Geometry& geometry, const Size3& size);

/// How far the eight corner voxels of a grid lie apart in two geometries, at most, mm.
double largest_shift_mm(const Geometry& a, const Geometry& b, const Size3& size);

/// The shift below which two geometries count as the same: a thousandth of the finest spacing.
double shift_tolerance_mm(const Geometry& geometry);

}  // namespace octavo
