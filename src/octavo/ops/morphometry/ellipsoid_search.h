// The largest ellipsoid between places that none may hold.
//
// From a first ellipsoid on, its center, its axes and their lengths are changed at random, and a
// change stays where the ellipsoid that then fits is larger:
//
//     o      o                  o      o        an ellipsoid of any form fits at one size: up to
//        __        o     ->   _____  ,   o      the place that it meets first
//     o (__)               o (_____)
//           o                     o
//
// Source  M. Doube, The ellipsoid factor for quantification of rods, plates, and intermediate forms
//         in 3D geometries, Frontiers in Endocrinology 6 (2015)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"

namespace octavo {

struct FreeEllipsoid {
  Point3 center{};
  std::array<Point3, 3> axes{};  ///< of length 1, square to each other
  Point3 lengths{};              ///< from the center to the surface
};

class EllipsoidSearch {
 public:
  /// drift    how far the center may move from 0
  /// longest  no axis becomes longer
  /// seed     of what is tried
  EllipsoidSearch(double drift, double longest, std::uint64_t seed);

  /// A place that no ellipsoid may hold.
  void add(const Point3& place);

  /// Makes an ellipsoid as large as its places let it be, then tries so many changes of it.
  void improve(FreeEllipsoid& ellipsoid, int tries);

 private:
  double size_of(const FreeEllipsoid& form) const;
  double random();
  Point3 random_place(double reach);

  double drift_;
  double longest_;
  std::uint64_t state_;
  double step_ = 0.3;
  int failed_ = 0;
  std::array<std::vector<float>, 3> places_;
};

}  // namespace octavo
