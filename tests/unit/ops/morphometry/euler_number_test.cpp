#include "octavo/ops/morphometry/euler_number.h"

#include <gtest/gtest.h>

#include "support/dense_mask.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

template <class Inside>
EulerNumbers numbers_of(const Size3& size, Inside inside) {
  DenseMask mask{size, std::vector<std::uint8_t>(static_cast<std::size_t>(size.voxel_count()))};
  for_each_voxel(size, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  NoProgress progress;
  return euler_numbers(testing::tree_of(mask), progress);
}

TEST(EulerNumbers, ArePiecesLessTunnelsPlusCavities) {
  const Size3 size = {20, 20, 40};
  const auto is_block = [](const Index3& p) {
    return p.x > 2 && p.x < 17 && p.y > 2 && p.y < 17 && p.z > 2 && p.z < 35;
  };
  EXPECT_EQ(numbers_of(size, [](const Index3&) { return false; }), (EulerNumbers{0, 0, 0}));
  EXPECT_EQ(numbers_of(size, is_block), (EulerNumbers{1, 1, 1}));
  const auto is_with_tunnel = [&](const Index3& p) {
    return is_block(p) && !(p.x == 8 && p.y == 9);
  };
  EXPECT_EQ(numbers_of(size, is_with_tunnel), (EulerNumbers{0, 0, 0}));
  const auto is_with_cavity = [&](const Index3& p) {
    return is_block(p) && !(p.x == 8 && p.y == 9 && p.z == 16);
  };
  EXPECT_EQ(numbers_of(size, is_with_cavity), (EulerNumbers{2, 2, 2}));
}

TEST(EulerNumbers, DifferWhereVoxelsTouchAtCorners) {
  const EulerNumbers two = numbers_of({6, 6, 6}, [](const Index3& p) {
    return p == Index3{2, 2, 2} || p == Index3{3, 3, 3};
  });
  EXPECT_EQ(two.corners, 1);
  EXPECT_EQ(two.faces, 2);
}

TEST(EulerNumbers, WeighWhatLiesInTheBorder) {
  // A voxel in the corner of the volume: an eighth of a whole one.
  EXPECT_EQ(numbers_of({5, 5, 5}, [](const Index3& p) { return p == Index3{0, 0, 0}; }).share,
            1.0 / 8);
  // A rod from side to side is half of a piece at each end: none is cut off from the whole.
  EXPECT_EQ(numbers_of({5, 5, 40}, [](const Index3& p) { return p.x == 2 && p.y == 2; }).share, 0);
  EXPECT_EQ(numbers_of({5, 5, 5}, [](const Index3&) { return true; }).share, 0);
}

/// Counts cells one by one: those of places 2 * index + 1 are as long as a voxel, others a point.
EulerNumbers counted_numbers(const DenseMask& mask) {
  EulerNumbers numbers;
  const Size3& n = mask.size;
  for_each_voxel({2 * n.x + 1, 2 * n.y + 1, 2 * n.z + 1}, [&](const Index3& cell) {
    int points = 0;
    int borders = 0;
    for (int axis = 0; axis < 3; ++axis) {
      points += cell[axis] % 2 == 0 ? 1 : 0;
      borders += cell[axis] == 0 || cell[axis] == 2 * n[axis] ? 1 : 0;
    }
    bool is_any = false;
    bool is_all = borders == 0;
    for_each_voxel({2, 2, 2}, [&](const Index3& step) {
      Index3 voxel;
      for (int axis = 0; axis < 3; ++axis) {
        voxel[axis] = cell[axis] % 2 == 0 ? cell[axis] / 2 - step[axis] : cell[axis] / 2;
      }
      const bool is_inside = box_of(n).contains(voxel) && mask.at(voxel) != 0;
      is_any = is_any || is_inside;
      is_all = is_all && is_inside;
    });
    const int closed = points % 2 == 1 ? 1 : -1;
    numbers.corners += is_any ? closed : 0;
    numbers.share += is_any ? closed / static_cast<double>(1 << borders) : 0;
    numbers.faces += is_all ? (points % 2 == 0 ? 1 : -1) : 0;
  });
  return numbers;
}

TEST(EulerNumbers, AreThoseOfCellsCountedOneByOne) {
  std::mt19937 random(11);
  for (const Size3& size : {Size3{30, 21, 50}, {1, 1, 1}, {7, 1, 33}, {16, 17, 16}, {5, 40, 2}}) {
    DenseMask mask = testing::random_mask(size, random);
    for (std::uint8_t& voxel : mask.voxels) {
      if (random() % 5 == 0) voxel = voxel == 0 ? 1 : 0;
    }
    NoProgress progress;
    EXPECT_EQ(euler_numbers(testing::tree_of(mask), progress), counted_numbers(mask));
  }
}

}  // namespace
}  // namespace octavo
