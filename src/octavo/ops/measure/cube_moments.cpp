#include "octavo/ops/measure/cube_moments.h"

#include <bit>

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/mask_kernels.h"

namespace octavo {

namespace {

// The voxels of `sums`, counted from `corner`, counted from the volume's first voxel.
void move(MomentSums& sums, const Index3& corner) {
  const std::array<__int128, 3> by = {corner.x, corner.y, corner.z};
  const auto count = static_cast<__int128>(sums.count);
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t a = MomentSums::kPairs[i][0];
    const std::size_t b = MomentSums::kPairs[i][1];
    sums.second[i] += by[a] * sums.first[b] + by[b] * sums.first[a] + by[a] * by[b] * count;
  }
  for (std::size_t a = 0; a < 3; ++a) sums.first[a] += by[a] * count;
}

// Adds sums counted from `corner`.
void add(const SmallSums& sums, const Index3& corner, MomentSums& to) {
  MomentSums wide;
  wide.count = static_cast<std::uint64_t>(sums.count);
  for (std::size_t a = 0; a < 3; ++a) wide.first[a] = sums.first[a];
  for (std::size_t i = 0; i < 6; ++i) wide.second[i] = sums.second[i];
  move(wide, corner);
  to.add(wide);
}

}  // namespace

void add_children(std::uint64_t bits, std::int64_t side, const Index3& corner, MomentSums& to) {
  if (bits == 0) return;
  to.box = united(to.box, box_of_children(bits, corner, side));
  const SmallSums cells = sums_of_bits(bits);
  const __int128 s = side;
  const __int128 line = MomentSums::sum_below(side);  // of the offsets inside a child
  const __int128 squares = MomentSums::squares_below(side);
  MomentSums wide;
  wide.count = static_cast<std::uint64_t>(cells.count * side * side * side);
  for (std::size_t a = 0; a < 3; ++a) {
    const __int128 sum = cells.first[a];
    wide.first[a] = s * s * (s * s * sum + line * cells.count);
    wide.second[a] =
        s * s * (s * s * s * cells.second[a] + 2 * s * line * sum + squares * cells.count);
  }
  for (std::size_t i = 3; i < 6; ++i) {
    const __int128 sum =
        cells.first[MomentSums::kPairs[i][0]] + cells.first[MomentSums::kPairs[i][1]];
    wide.second[i] =
        s * (s * s * s * s * cells.second[i] + s * s * line * sum + line * line * cells.count);
  }
  move(wide, corner);
  to.add(wide);
}

void add_words(std::uint64_t mixed, const std::uint64_t* words, const Index3& corner,
               MomentSums& to) {
  if (mixed == 0) return;
  add(sums_of_words(mixed, words), corner, to);
  const std::int64_t side = child_side(0);
  if (to.box.contains(box_of_children(mixed, corner, side))) return;
  for (; mixed != 0; mixed &= mixed - 1) {
    const Index3 at = child_box(corner, std::countr_zero(mixed), side).lo;
    to.box = united(to.box, box_of_children(*words++, at, 1));
  }
}

}  // namespace octavo
