// Planes in, a linear octree out: condensation level by level, bottom up.
//
// Two adjacent planes hold whole octants. Where the eight siblings of an octant are homogeneous
// they are replaced by one cube a level up; where not, those of them that are cubes are final at
// their level:
//
//      plane z    plane z+1        level 1 plane         level 1 list of finished codes
//      a a b b     a a b c           A  .                 (none yet)
//      a a b b     a a b b     ->    .  .   ->  goes up to be paired with the next level 1 plane
//
// Only the plane of condensed cubes goes up, a quarter of the cells each time, and it meets its
// partner there after 2^k source planes. So at most one waiting plane per level is held.
//
// Invariants
//   A cube is condensed exactly when it lies inside the volume and all its voxels are homogeneous:
//   max - min <= flat, none of them or all of them background.
// Consequences
//   Memory is that of two source planes and their coarser ones (below 40 bytes per voxel of a
//   plane) besides the leaves; it does not depend on the number of planes.
//   An octant that reaches outside the volume is never condensed, so sizes need not be powers of
//   two. The octree is sorted, linear and complete, and no eight sibling leaves are homogeneous.
//
// Source  thesis 2.4 (Fig. 2.3)
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/voxel_type.h"
#include "octavo/octree/linear_octree.h"

namespace octavo {

struct CondenseOptions {
  std::optional<std::int64_t> background{};  ///< voxels of this value get no leaf
  std::int64_t flat = 0;  ///< an octant is homogeneous when max - min <= flat; 0 is equality
};

/// Takes the planes of one volume in z order and gives its octree. One thread at a time.
class PlaneCondenser {
 public:
  /// Throws Error{limit_exceeded} on a bad size; Error{invalid_argument} on flat < 0 or so large
  /// that the mean of a cube is beyond 64-bit sums (flat >= 2^62 / 8^n).
  PlaneCondenser(const Size3& size, const CondenseOptions& options);

  /// Takes the next plane, [y][x], size.x * size.y voxels of an integer type.
  /// Throws Error{invalid_argument} when the plane has another length, the type is float32 or all
  /// planes were given already.
  void add_plane(VoxelType type, std::span<const std::byte> plane);

  /// Bytes of the leaves so far and of the planes that wait.
  std::uint64_t memory_bytes() const noexcept;

  /// The octree of all planes. A leaf's value is that of its voxels, or with `flat` their mean,
  /// halves rounded up. Call it once. Throws Error{invalid_argument} when planes are missing.
  LinearOctree finish();

 private:
  enum class State : std::uint8_t { mixed, background, cube };

  // A cell of the plane at one level. Means come from min and the sum of all that voxels have above
  // it.
  struct Cell {
    std::int64_t min = 0;
    std::int64_t max = 0;
    std::uint64_t excess = 0;
    State state = State::mixed;
  };

  // The cells of one level's plane, [y][x].
  struct Plane {
    std::int64_t width = 0;
    std::int64_t height = 0;
    std::vector<Cell> cells;
  };

  // A level while it is built: the plane that waits for its partner, and how many were seen.
  struct Waiting {
    Plane plane;
    bool is_held = false;
    std::int64_t seen = 0;
  };

  Cell voxel_cell(std::int64_t value) const;
  Cell condensed(const Cell* const (&siblings)[8], int level) const;
  void pair_voxels(std::span<const std::int64_t> lower, std::span<const std::int64_t> upper);
  void take_plane(int level, Plane plane);
  void pair_cells(int level, const Plane& lower, const Plane* upper);
  void emit(int level, const Index3& cell, const Cell& leaf);
  void sort_leaves();

  Size3 size_;
  CondenseOptions options_;
  LinearOctree octree_;
  std::vector<std::int64_t> voxels_;        // the plane being taken
  std::vector<std::int64_t> voxels_below_;  // the one before it, when it still waits
  std::int64_t plane_count_ = 0;
  std::vector<Waiting> waiting_;
};

/// Condenses a volume in memory, [z][y][x], x fastest.
/// Throws  as PlaneCondenser
template <class T>
LinearOctree condense(std::span<const T> voxels, const Size3& size, const CondenseOptions& options);

/// The volume of an octree, [z][y][x], with `background` where no leaf is.
/// Throws Error{invalid_argument} when a leaf reaches outside `size`.
std::vector<std::int64_t> expand(const LinearOctree& octree, const Size3& size,
                                 std::int64_t background);

}  // namespace octavo
