// An orthographic look at a grid: where the corners of its voxels fall on a picture.
//
// The projections of the three index axes and of the grid's first corner are rounded once, to whole
// multiples of 2^-fraction_bits pixels. From then on everything is integer:
//
//     place of corner (i, j, k)  =  origin + i * axes[0] + j * axes[1] + k * axes[2]
//
// Invariants
//   No corner of the volume lies 2^30 units or more from the picture's upper left corner, so the
//   product of two distances fits in 64 bits.
//   `nearness` is the sign of the direction towards the viewer in index space, taken from the
//   rounded axes: it says exactly which faces of a voxel are seen, and which of two voxels is
//   nearer.
// Consequences
//   Corners on a line stay on a line, and a cube of any size has exactly the outline of its voxels.
//   Voxels are drawn true in size whatever the spacing.
//
// Source  thesis 4.3
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "octavo/core/geometry.h"

namespace octavo {

/// From where one looks, in world space (LPS).
struct Viewpoint {
  Point3 toward = {0, -1, 0};  ///< unit vector from the object to the viewer
  Point3 up = {0, 0, 1};       ///< unit vector, at a right angle to it, that is up in the picture
};

/// From where a picture is drawn when nothing else is asked for: the view (1, 1, 1) of the thesis,
/// in the axes of the patient.
inline constexpr std::string_view kUsualViewpoint = "left-front-top";

/// The viewer stands `steps` voxels along the index axes away from the object. Up is towards the
/// head, and to the front of the body when one looks along it.
/// Throws Error{invalid_argument} when all steps are 0 or one is not finite.
Viewpoint viewpoint_along(const Geometry& geometry, const Point3& steps);

/// front, back, left, right, top or bottom: the side of the patient where the viewer stands. Sides
/// of different axes may be joined by "-": "left-front-top" is as much to the left as it is to the
/// front and above.
std::optional<Viewpoint> find_viewpoint(std::string_view name);

/// A name of each of the 26 viewpoints that find_viewpoint knows, which takes joined sides in any
/// order.
std::vector<std::string> viewpoint_names();

/// Azimuth 0 is the front, 90 the patient's left; elevation 90 is above the head. Degrees.
/// Throws Error{invalid_argument} when one is not finite.
Viewpoint viewpoint_at(double azimuth_degrees, double elevation_degrees);

/// The viewer moved around the head-foot axis, from the front towards the patient's left.
Viewpoint turned(const Viewpoint& viewpoint, double degrees);

/// A place in a picture, in units of 2^-fraction_bits pixels: x to the right, y down, depth towards
/// the viewer.
struct Place {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t depth = 0;

  bool operator==(const Place&) const = default;
  constexpr Place operator+(const Place& p) const { return {x + p.x, y + p.y, depth + p.depth}; }
  constexpr Place operator*(std::int64_t n) const { return {x * n, y * n, depth * n}; }
};

struct ViewFrame {
  static constexpr std::int64_t kLongestSide = 16384;

  std::int64_t width = 1024;
  std::int64_t height = 1024;
  double zoom = 1;
  /// Side of a pixel at zoom 1; by default the shown box fits with a small margin.
  std::optional<double> pixel_mm;
};

struct View {
  std::int64_t width = 0;
  std::int64_t height = 0;
  double pixel_mm = 1;
  Point3 right{};  ///< unit vectors in world space
  Point3 up{};
  Point3 toward{};
  Point3 middle{};  ///< of the picture, as corners of voxels are counted
  int fraction_bits = 1;          ///< at least 1: the middle of a pixel is a whole number
  Place origin;                   ///< of the lowest corner of voxel (0, 0, 0)
  std::array<Place, 3> axes;      ///< one voxel along each index axis
  std::array<int, 3> nearness{};  ///< -1, 0 or 1: towards the viewer, by index axis

  Place place_of(const Index3& corner) const {
    return origin + axes[0] * corner.x + axes[1] * corner.y + axes[2] * corner.z;
  }
};

/// The side of a pixel with which a box of voxels fits a picture, mm.
double fitting_pixel_mm(const Geometry& geometry, const Box& shown, const Viewpoint& viewpoint,
                        const ViewFrame& frame);

/// The middle of a box, as corners of voxels are counted.
Point3 middle_of(const Box& voxels);

/// Looks at a volume of `size` voxels; the place `middle`, between its corners (i, j, k), is the
/// picture's middle.
/// frame  with the side of its pixels
/// Throws as make_view
View view_around(const Geometry& geometry, const Size3& size, const Point3& middle,
                 const Viewpoint& viewpoint, const ViewFrame& frame);

/// Looks at a volume of `size` voxels; the middle of `shown`, a box in it, is the picture's middle.
/// Throws Error{invalid_argument} on a frame without pixels, with sides above kLongestSide or a
///        zoom or pixel that is not positive, and when a voxel is too small or too flat to be seen;
///        Error{limit_exceeded} when the volume would be 2^29 pixels long.
View make_view(const Geometry& geometry, const Size3& size, const Box& shown,
               const Viewpoint& viewpoint, const ViewFrame& frame);

/// The patient's sides at the four edges of a picture: one letter of R L A P S I where the nearest
/// side is clear, more where it is not, the nearest first ("RA"); nothing where none is known.
struct EdgeLetters {
  std::string left;
  std::string right;
  std::string top;
  std::string bottom;

  bool operator==(const EdgeLetters&) const = default;
};

EdgeLetters edge_letters(const View& view);

/// The sides of the body in a direction (LPS), as at an edge of a picture.
std::string side_letters(const Point3& direction);

/// Whether every edge has one letter: the picture is seen from a side of the patient, not from an
/// edge or a corner.
bool is_seen_from_a_side(const View& view);

/// An axis as a picture has it: parts of a unit vector to its right, up, and towards the viewer.
struct ViewAxis {
  std::string name;
  double right = 0;
  double up = 0;
  double toward = 0;
};

/// The three axes of the patient, each towards the side that is nearer to the viewer: L or R, A or
/// P, S or I.
std::array<ViewAxis, 3> patient_axes(const View& view);

/// The three axes of the grid, the way its indices grow: x, y, z.
std::array<ViewAxis, 3> grid_axes(const View& view);

}  // namespace octavo
