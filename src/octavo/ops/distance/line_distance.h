// One pass of the signed distance transform: along a line of voxels.
//
// A voxel holds the squared distance to the nearest voxel of the other class that earlier passes
// found, signed: below 0 inside, above 0 outside, infinite where there is none yet. A pass looks
// along its axis as well:
//
//     squared(p) = min over q in the run of p of  weight * (p - q)^2 + squared(q)
//
// A run is what lies side by side in one class. Voxels behind its ends count for nothing: the
// voxel of the other class that ends it is nearer than all behind it. So one pass serves both
// classes, and each run is a lower envelope of parabolas, in time linear in its voxels.
//
// To faces, voxels of the other class are cubes in place of points: the parabolas stand on the
// faces between voxels, half a step away, and none on the voxel itself.
//
// Source  Meijster, Roerdink, Hesselink, "A general algorithm for computing distance transforms in
//         linear time" (2000); Felzenszwalb, Huttenlocher, "Distance transforms of sampled
//         functions" (2012)
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

/// Where distances of a voxel's center end.
enum class DistanceTo : std::uint8_t {
  faces,   ///< at the faces between the mask and what is not in it: voxels are cubes
  centers  ///< at the center of the nearest voxel of the other class
};

/// Works along lines of one axis. One thread at a time.
class LineDistance {
 public:
  /// longest  voxels of a line
  /// weight   the squared distance between neighbors
  LineDistance(std::int64_t longest, double weight, DistanceTo to);

  /// The first pass of all.
  /// mask  0 or not, one a voxel
  void begin(std::span<const std::uint8_t> mask, std::span<float> squared) const;

  /// A further pass, in place. Time linear.
  void improve(std::span<float> squared);

 private:
  void add_parabola(double place, double height);
  void improve_run(std::span<float> squared, std::size_t begin, std::size_t end);

  struct Parabola {
    double place;
    double height;
    double start;  ///< from where on it is the lowest
  };

  double weight_;
  bool is_to_faces_;
  std::vector<double> half_inverse_;  ///< 1 / (2 * weight * distance)
  std::vector<Parabola> envelope_;
  std::size_t count_ = 0;
};

}  // namespace octavo
