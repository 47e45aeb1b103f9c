// Pores that lead from the first plane across an axis to the last, and how they hang together.
//
// Pores are numbered from 1 on in raster order, row by row, and number 0 stands for what is no
// pore. Vectors over pores begin with an unused 0, so a sum over neighbors asks no question:
//
//     mask     . x x . x        number   0 1 2 0 3        vector   0 a b c
//
// Between the centers of two pores side by side the conductance is area / distance of their face;
// pores of the outermost planes are half a voxel from where the concentration is held.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/error.h"
#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

/// The pores of one row along x: numbers [begin, end).
struct PoreRow {
  std::int64_t y = 0;
  std::int64_t z = 0;
  std::int32_t begin = 0;
  std::int32_t end = 0;
};

/// Their numbers, and the one behind them, are 32 bits wide.
constexpr std::int64_t kMostPores = std::numeric_limits<std::int32_t>::max() - 1;

class PoreNetwork {
 public:
  /// pores  [z][y][x], not 0 in pores
  /// Throws  Error{limit_exceeded} beyond kMostPores that lead through, Error{cancelled}
  /// Memory  4 bytes a voxel, 5 a pore; at first 5 bytes a voxel and up to 8 a pore
  PoreNetwork(const std::vector<std::uint8_t>& pores, const Size3& size, const Point3& spacing_mm,
              int axis, const Progress& progress);

  const Size3& size() const { return size_; }
  int axis() const { return axis_; }
  const Point3& spacing_mm() const { return spacing_; }
  /// Vectors have one more.
  std::size_t count() const { return along_x_.size() - 1; }
  std::int64_t row_count() const { return size_.y * size_.z; }
  PoreRow row(std::int64_t y, std::int64_t z) const {
    const auto at = static_cast<std::size_t>(z * size_.y + y);
    return {y, z, row_starts_[at], row_starts_[at + 1]};
  }
  std::int64_t x_of(std::int32_t pore) const { return along_x_[static_cast<std::size_t>(pore)]; }
  /// The place across the planes that the axis counts.
  std::int64_t along(std::int32_t pore, const PoreRow& row) const {
    return Index3{x_of(pore), row.y, row.z}[axis_];
  }
  bool is_first(std::int32_t pore) const { return (faces(pore) & kAtFirstPlane) != 0; }
  bool is_last(std::int32_t pore) const { return (faces(pore) & kAtLastPlane) != 0; }
  /// All conductances of a pore together.
  double diagonal(std::int32_t pore) const { return diagonal_[faces(pore)]; }
  /// From the center of an outermost pore to where its concentration is held.
  double end_conductance() const { return 2 * conductance_[static_cast<std::size_t>(axis_)]; }
  /// To both ends together, 0 inside.
  double to_ends(std::int32_t pore) const { return to_ends(unsigned{faces(pore)}); }

  /// Visits the neighbors of a pore: visit(side, neighbor, conductance), sides -x, +x, -y, ...
  template <class Visit>
  void visit_links(std::int32_t pore, const PoreRow& row, Visit visit) const {
    const std::array<std::int32_t, 6> neighbors = neighbors_of(pore, rows_beside(row));
    for (std::size_t side = 0; side < 6; ++side) {
      if (neighbors[side] == 0) continue;
      visit(static_cast<int>(side), neighbors[side], conductance_[side / 2]);
    }
  }

  /// Calls work(pore, sum) for the pores of a row, sum the conductances to their neighbors times
  /// the values there; `c` has a value a pore.
  /// is_asked(pore)  leaves out those for which it is false
  template <class T, class Asked, class Work>
  void for_neighbor_sums(const PoreRow& row, const std::vector<T>& c, Asked is_asked,
                         Work work) const {
    const RowsBeside beside = rows_beside(row);
    const auto value = [&](std::int32_t pore) {
      return static_cast<double>(c[static_cast<std::size_t>(pore)]);
    };
    for (std::int32_t pore = row.begin; pore < row.end; ++pore) {
      if (!is_asked(pore)) continue;
      const std::array<std::int32_t, 6> at = neighbors_of(pore, beside);
      work(pore, conductance_[0] * (value(at[0]) + value(at[1])) +
                     conductance_[1] * (value(at[2]) + value(at[3])) +
                     conductance_[2] * (value(at[4]) + value(at[5])));
    }
  }

  /// Calls work(row) for all rows, in parallel. Throws Error{cancelled}.
  template <class Work>
  void for_rows(Work work) const {
    parallel_for(std::int64_t{0}, group_count(), [&](std::int64_t i) {
      in_group(i, work);
    });
  }

  /// The sum of sum(row) over all rows, which does not depend on threads. Throws Error{cancelled}.
  template <class Sum>
  double sum_of_rows(Sum sum) const {
    std::vector<double> parts(static_cast<std::size_t>(group_count()));
    parallel_for(std::int64_t{0}, group_count(), [&](std::int64_t i) {
      double part = 0;
      in_group(i, [&](const PoreRow& row) { part += sum(row); });
      parts[static_cast<std::size_t>(i)] = part;
    });
    double all = 0;
    for (const double part : parts) all += part;
    return all;
  }

  void stop_if_cancelled() const {
    if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
  }

 private:
  /// The numbers in the four rows beside one, by x.
  using RowsBeside = std::array<const std::int32_t*, 4>;

  // Bits of faces_: the first six say on which sides, in the order of visit_links, a pore is.
  static constexpr unsigned kPoreBefore = 1;       // along x
  static constexpr unsigned kPoreBehind = 2;
  static constexpr unsigned kFirstPoreAcross = 4;  // -y, then +y, -z and +z
  static constexpr unsigned kAtFirstPlane = 64;
  static constexpr unsigned kAtLastPlane = 128;

  double to_ends(unsigned bits) const {
    const int ends = ((bits & kAtFirstPlane) != 0 ? 1 : 0) + ((bits & kAtLastPlane) != 0 ? 1 : 0);
    return ends * end_conductance();
  }

  std::uint8_t faces(std::int32_t pore) const { return faces_[static_cast<std::size_t>(pore)]; }

  RowsBeside rows_beside(const PoreRow& row) const {
    const std::int32_t* const own = numbers_.data() + (row.z * size_.y + row.y) * size_.x;
    const std::int64_t plane = size_.x * size_.y;
    const std::int32_t* const none = no_numbers_.data();
    return {row.y > 0 ? own - size_.x : none, row.y + 1 < size_.y ? own + size_.x : none,
            row.z > 0 ? own - plane : none, row.z + 1 < size_.z ? own + plane : none};
  }

  std::array<std::int32_t, 6> neighbors_of(std::int32_t pore, const RowsBeside& beside) const {
    const std::int32_t x = along_x_[static_cast<std::size_t>(pore)];
    const std::uint8_t bits = faces(pore);
    return {(bits & kPoreBefore) != 0 ? pore - 1 : 0,
            (bits & kPoreBehind) != 0 ? pore + 1 : 0,
            beside[0][x],
            beside[1][x],
            beside[2][x],
            beside[3][x]};
  }

  std::int64_t rows_at_once() const { return std::max<std::int64_t>(1, (1 << 15) / size_.x); }
  std::int64_t group_count() const {
    return (row_count() + rows_at_once() - 1) / rows_at_once();
  }
  template <class Work>
  void in_group(std::int64_t group, Work work) const {
    stop_if_cancelled();
    const std::int64_t end = std::min((group + 1) * rows_at_once(), row_count());
    for (std::int64_t r = group * rows_at_once(); r < end; ++r) work(row(r % size_.y, r / size_.y));
  }

  void number(const std::vector<std::uint8_t>& reached);
  void look_around();

  Size3 size_;
  int axis_;
  Point3 spacing_;
  const Progress& progress_;
  Point3 conductance_{};                  // of a face across each axis
  std::vector<std::int32_t> numbers_;     // of every voxel
  std::vector<std::int32_t> no_numbers_;  // of a row outside
  std::vector<std::int32_t> row_starts_;
  std::vector<std::int32_t> along_x_;  // of every pore
  std::vector<std::uint8_t> faces_;    // bits, as above
  std::array<double, 256> diagonal_{};
};

}  // namespace octavo
