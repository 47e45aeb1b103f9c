// The sum of squared distances of a place to planes, as a quadratic function of the place.
//
// Source  Garland and Heckbert, Surface simplification using quadric error metrics, 1997
#pragma once

#include <array>

#include "octavo/core/vectors.h"

namespace octavo {

class Quadric {
 public:
  /// Adds `weight` times the squared distance to the plane through `place` with a unit normal.
  void add_plane(const Point3& normal, const Point3& place, double weight) {
    const double offset = -dot(normal, place);
    const std::array<double, 4> plane = {normal[0], normal[1], normal[2], offset};
    std::size_t at = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i; j < 4; ++j) terms_[at++] += weight * plane[i] * plane[j];
    }
    weight_ += weight;
  }

  void add(const Quadric& other) {
    for (std::size_t i = 0; i < terms_.size(); ++i) terms_[i] += other.terms_[i];
    weight_ += other.weight_;
  }

  /// The sum of all weights.
  double weight() const { return weight_; }

  double at(const Point3& p) const {
    const auto& [xx, xy, xz, xd, yy, yz, yd, zz, zd, dd] = terms_;
    const double value = xx * p[0] * p[0] + yy * p[1] * p[1] + zz * p[2] * p[2] + dd +
                         2 * (xy * p[0] * p[1] + xz * p[0] * p[2] + yz * p[1] * p[2] +
                              xd * p[0] + yd * p[1] + zd * p[2]);
    return value > 0 ? value : 0;
  }

  /// The place where the sum is smallest, drawn a little to `start` where planes leave it open.
  Point3 lowest_place(const Point3& start) const {
    const auto& [xx, xy, xz, xd, yy, yz, yd, zz, zd, dd] = terms_;
    const double pull = 1e-3 * weight_;
    const double a = xx + pull;
    const double b = yy + pull;
    const double c = zz + pull;
    const Point3 target = {pull * start[0] - xd, pull * start[1] - yd, pull * start[2] - zd};
    // The inverse by cofactors.
    const double aa = b * c - yz * yz;
    const double ab = xz * yz - xy * c;
    const double ac = xy * yz - xz * b;
    const double share = 1 / (a * aa + xy * ab + xz * ac);
    const double bb = a * c - xz * xz;
    const double bc = xy * xz - a * yz;
    const double cc = a * b - xy * xy;
    return {(aa * target[0] + ab * target[1] + ac * target[2]) * share,
            (ab * target[0] + bb * target[1] + bc * target[2]) * share,
            (ac * target[0] + bc * target[1] + cc * target[2]) * share};
  }

 private:
  std::array<double, 10> terms_{};  // xx xy xz xd yy yz yd zz zd dd
  double weight_ = 0;
};

}  // namespace octavo
