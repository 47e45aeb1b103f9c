// The ladder of levels over a volume: sizes, halved axes, and how levels group into bricks.
//
// Level 0 is the scan. A level is made from the one below by halving some axes (a mask of three
// bits); the size along a halved axis becomes ceil(size / 2). The ladder ends at the first level of
// size 1x1x1.
//
// Six levels form a tier. A brick of tier t is the subtree over one sample of level 6t+6: it holds
// the samples of levels 6t .. 6t+5 above it. With all axes halved it covers 64^3 samples of level
// 6t; an axis that some of the six levels leave alone makes it flatter. The samples of level 6t+6
// are cut into the bricks of tier t+1 in the same way.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"

namespace octavo {

/// Bit a is set when axis a (0 = x, 1 = y, 2 = z) is halved on the way to the next coarser level.
using HalvingMask = std::uint8_t;
inline constexpr HalvingMask kHalveAll = 7;

inline constexpr int kTierLevels = 6;
inline constexpr std::int64_t kMaxAxis = std::int64_t{1} << 21;
inline constexpr int kMaxLevels = 32;

/// x*y*z after proving 1 <= axis <= 2^21 and fewer than 2^63 voxels. Throws Error{limit_exceeded}.
std::int64_t checked_voxel_count(const Size3& size);

/// The halved axes of every level for a grid: all axes while spacings are alike; an axis whose
/// spacing is at least twice the finest one waits until the others have caught up (at most 4
/// levels).
/// The result has one mask per level below the root and ends where the size is 1x1x1.
std::vector<HalvingMask> choose_halvings(const Size3& size, const Point3& spacing_mm);

/// The ladder of one volume. Immutable.
class Levels {
 public:
  Levels() = default;
  /// Throws Error{limit_exceeded} on a bad size; Error{corrupt} when the masks do not lead from
  /// `size` to 1x1x1 exactly at their end, halve nothing in a step, or a tier leaves an axis with
  /// fewer than 2 halvings while it is longer than 4.
  Levels(const Size3& size, std::vector<HalvingMask> halvings);

  /// Levels 0 .. count-1; level count-1 is a single sample.
  int count() const { return static_cast<int>(sizes_.size()); }
  const Size3& size(int level) const { return sizes_[static_cast<std::size_t>(level)]; }
  const std::vector<HalvingMask>& halvings() const { return halvings_; }
  /// The axes halved from `level` to `level + 1`; 0 for the last level.
  HalvingMask halving(int level) const;
  /// How many times `axis` has been halved between level 0 and `level`.
  int halving_count(int level, int axis) const;

  /// Spacing and origin of a level: a coarse sample sits at the center of the voxels it stands for.
  Geometry geometry(const Geometry& level0, int level) const;

  int tier_count() const { return (count() + kTierLevels - 1) / kTierLevels; }
  static int tier_of(int level) { return level / kTierLevels; }
  static int first_level(int tier) { return tier * kTierLevels; }
  /// Levels held in one brick of a tier: 6, or fewer in the last tier.
  int tier_level_count(int tier) const;
  /// Side lengths of a full brick in samples of level 6 * tier.
  Size3 brick_side(int tier) const;
  /// Bricks per axis.
  Size3 brick_grid(int tier) const;
  std::int64_t brick_count(int tier) const { return brick_grid(tier).voxel_count(); }
  /// The samples of level 6 * tier that a brick covers, clipped at the border of the volume.
  Box brick_box(int tier, const Index3& brick) const;

 private:
  std::vector<Size3> sizes_;
  std::vector<HalvingMask> halvings_;
};

/// ceil(size / 2) along the axes of `mask`.
Size3 halved(const Size3& size, HalvingMask mask);

/// How many voxels of level 0 the two samples of a pair stand for, along the axis of the pair.
struct PairWeights {
  std::int64_t first = 1;
  std::int64_t second = 1;

  bool are_equal() const { return first == second; }
};

/// How many voxels of level 0 samples stand for, along each axis: the last one for those that are
/// left of the volume, all others for as many as the axis was halved to.
struct SampleWeights {
  Size3 each{1, 1, 1};
  Size3 last{1, 1, 1};

  bool operator==(const SampleWeights&) const = default;
  /// Of the last pair among `count` samples along `axis`; all other pairs weigh alike.
  PairWeights last_pair(int axis, std::int64_t count) const {
    return {each[axis], count % 2 == 0 ? last[axis] : each[axis]};
  }
};

/// The shape of one brick: the sizes of its own ladder.
struct BrickShape {
  int first_level = 0;                            ///< global level of its finest samples
  int level_count = 0;                            ///< levels inside, 1..6
  std::array<Size3, kTierLevels> size{};          ///< size[i] at level first_level + i
  std::array<HalvingMask, kTierLevels>
      halving{};  ///< halving[i] from first_level+i to the next; the one
                  ///< of the last level leads to the next tier, 0 at the root
  SampleWeights weights;  ///< of the samples of size[0]
};

/// The shape of brick `brick` of `tier`.
BrickShape brick_shape(const Levels& levels, int tier, const Index3& brick);

/// The weights of the samples of in-brick level `level`.
SampleWeights weights_of(const BrickShape& shape, int level);

}  // namespace octavo
