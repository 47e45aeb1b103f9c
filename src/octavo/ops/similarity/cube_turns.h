// The 48 ways to lay a cube onto itself, as tables of places, and numbers of a cube that none of
// them changes.
//
// Voxels of a cube of side s fall into orbits: two are of one orbit where some turn or mirror takes
// one to the other. The eight voxels on the diagonals at equal distance from the middle are one.
// Sorted, the values of an orbit do not depend on how the cube lies; and where every voxel changes
// by at most T, so does every sorted value.
//
// Source  thesis 5.1; A. Jacquin, Image coding based on a fractal theory of iterated contractive
//         image transformations, IEEE Transactions on Image Processing 1 (1992)
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace octavo {

inline constexpr int kCubeTurns = 48;

class CubeTurns {
 public:
  /// side  2 or more, even
  explicit CubeTurns(int side);

  int side() const { return side_; }
  std::size_t voxel_count() const { return places_[0].size(); }

  /// places(t)[i] is the voxel that turn t brings to place i, [z][y][x]. Turn 0 changes nothing.
  std::span<const std::uint16_t> places(int turn) const {
    return places_[static_cast<std::size_t>(turn)];
  }

  /// How many numbers invariants() gives.
  std::size_t invariant_count() const { return 8 * diagonals_.size() + 2; }
  /// Smallest and largest voxel, then those of up to four diagonal orbits, sorted; less `mean`.
  void invariants(std::span<const std::int32_t> cube, std::int32_t mean,
                  std::span<std::int32_t> out) const;

  /// The turn that lays `cube` onto `other` within `most` at every voxel, each less its mean; -1
  /// where none does.
  int matching_turn(std::span<const std::int32_t> cube, std::int32_t mean,
                    std::span<const std::int32_t> other, std::int32_t other_mean,
                    std::int32_t most) const;

 private:
  int side_;
  std::array<std::vector<std::uint16_t>, kCubeTurns> places_;
  std::vector<std::array<std::uint16_t, 8>> diagonals_;
};

}  // namespace octavo
