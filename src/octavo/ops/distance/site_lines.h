// The nearest voxel of the other class, and what surrounds it: one pass, along a line.
//
// Every voxel holds the way to the nearest center of the other class that earlier passes found, in
// place of its length (line_distance.h has the method):
//
//      byte  0      2      4      6          7
//           +------+------+------+----------+----------+
//           |  x   |  y   |  z   | own      | site     |     voxels, from here to the site
//           +------+------+------+----------+----------+
//                                 bit 0: class    share of the site
//                                 bits 1-7: share of this voxel
//
// A share says how much of the surroundings of a voxel is of the other class, in steps of 1 / 168
// up to three quarters: by that, the surface that passes before a site is known to a tenth of a
// voxel. The largest value, kFlatShare, says that the surface is flat along an axis and passes half
// way.
//
// Source  Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in
//         linear time" (2000)
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "octavo/core/geometry.h"

namespace octavo {

inline constexpr std::uint8_t kFlatShare = 127;
inline constexpr double kSharesOfAll = 168;

/// The site of one voxel.
struct NearestSite {
  static constexpr std::int16_t kNone = std::numeric_limits<std::int16_t>::min();

  std::array<std::int16_t, 3> steps{kNone, 0, 0};
  std::uint8_t own = 0;
  std::uint8_t site_share = 0;

  bool is_inside() const noexcept { return (own & 1) != 0; }
  bool is_known() const noexcept { return steps[0] != kNone; }
  std::uint8_t own_share() const noexcept { return own >> 1; }
};
static_assert(sizeof(NearestSite) == 8);

/// Passes along lines of one axis. One thread at a time.
class SiteLine {
 public:
  /// longest  voxels of a line
  /// weights  the squared distances between neighbors along each axis
  SiteLine(std::int64_t longest, const Point3& weights, int axis);

  /// The first pass, along x, over voxels whose `own` is known.
  static void begin(std::span<NearestSite> line);

  /// A further pass, in place. Time linear.
  void improve(std::span<NearestSite> line);

 private:
  struct SiteParabola {
    double place;
    double height;
    double start;  ///< from where on it is the lowest
    NearestSite site;
  };

  void add(double place, double height, const NearestSite& site);
  void improve_run(std::span<NearestSite> line, std::size_t begin, std::size_t end);

  Point3 weights_;
  std::size_t axis_;
  std::vector<double> half_inverse_;  ///< 1 / (2 * weight * distance)
  std::vector<SiteParabola> envelope_;
  std::size_t count_ = 0;
};

}  // namespace octavo
