#include "octavo/ops/similarity/cube_turns.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace octavo {
namespace {

std::vector<std::int32_t> random_cube(const CubeTurns& turns, int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  std::vector<std::int32_t> cube(turns.voxel_count());
  for (std::int32_t& value : cube) value = static_cast<std::int32_t>(random() % 1000) - 500;
  return cube;
}

std::vector<std::int32_t> turned(const CubeTurns& turns, const std::vector<std::int32_t>& cube,
                                 int turn) {
  std::vector<std::int32_t> out;
  for (const std::uint16_t from : turns.places(turn)) out.push_back(cube[from]);
  return out;
}

TEST(CubeTurns, AreAllDifferentAndKeepNeighborsBesideEachOther) {
  const CubeTurns turns(4);
  std::set<std::vector<std::uint16_t>> all;
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    const auto places = turns.places(turn);
    all.emplace(places.begin(), places.end());
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      if (i % 4 == 3) continue;
      const int step = std::abs(int{places[i + 1]} - int{places[i]});
      EXPECT_TRUE(step == 1 || step == 4 || step == 16);
    }
  }
  EXPECT_EQ(all.size(), 48u);
}

TEST(CubeTurns, InvariantsAreThoseOfEveryTurnedCube) {
  for (const int side : {2, 4, 8, 16}) {
    const CubeTurns turns(side);
    const auto cube = random_cube(turns, side);
    std::vector<std::int32_t> own(turns.invariant_count());
    turns.invariants(cube, 7, own);
    for (int turn = 0; turn < kCubeTurns; ++turn) {
      std::vector<std::int32_t> other(turns.invariant_count());
      turns.invariants(turned(turns, cube, turn), 7, other);
      EXPECT_EQ(own, other) << turn;
    }
  }
}

TEST(CubeTurns, InvariantsMoveNoFartherThanVoxels) {
  const CubeTurns turns(8);
  const auto cube = random_cube(turns, 1);
  auto moved = cube;
  std::mt19937 random(3);
  for (std::int32_t& value : moved) value += static_cast<std::int32_t>(random() % 41) - 20;
  std::vector<std::int32_t> a(turns.invariant_count());
  std::vector<std::int32_t> b(turns.invariant_count());
  turns.invariants(cube, 0, a);
  turns.invariants(moved, 0, b);
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_LE(std::abs(a[i] - b[i]), 20);
}

TEST(CubeTurns, EveryTurnIsFoundAndOneStepMoreIsNot) {
  const CubeTurns turns(4);
  const auto cube = random_cube(turns, 5);
  for (int turn = 0; turn < kCubeTurns; ++turn) {
    auto other = turned(turns, cube, turn);
    EXPECT_EQ(turns.matching_turn(other, 0, cube, 0, 0), turn);
    for (std::int32_t& value : other) value += 100;
    EXPECT_EQ(turns.matching_turn(other, 100, cube, 0, 0), turn);
    other[13] += 3;
    EXPECT_EQ(turns.matching_turn(other, 100, cube, 0, 2), -1);
    EXPECT_EQ(turns.matching_turn(other, 100, cube, 0, 3), turn);
  }
}

}  // namespace
}  // namespace octavo
