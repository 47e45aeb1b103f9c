#include "octavo/ops/similarity/similar_cubes.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <random>

#include "octavo/ops/similarity/cube_turns.h"

namespace octavo {
namespace {

class SimilarCubesTest : public ::testing::Test {
 protected:
  SimilarCubesTest() {
    std::mt19937 random(11);
    voxels_.resize(static_cast<std::size_t>(size_.voxel_count()));
    for (std::int32_t& value : voxels_) value = static_cast<std::int32_t>(random() % 4096);
  }

  std::int32_t& at(std::int64_t x, std::int64_t y, std::int64_t z) {
    return voxels_[static_cast<std::size_t>((z * size_.y + y) * size_.x + x)];
  }

  /// Copies a cube, turned, changed by up to `noise`, with `shift` added.
  void copy(const Index3& from, const Index3& to, int side, int turn, int noise, int shift) {
    const CubeTurns turns(side);
    std::vector<std::int32_t> cube;
    for (int i = 0; i < side * side * side; ++i) {
      cube.push_back(at(from.x + i % side, from.y + i / side % side, from.z + i / side / side));
    }
    const auto places = turns.places(turn);
    for (int i = 0; i < side * side * side; ++i) {
      at(to.x + i % side, to.y + i / side % side, to.z + i / side / side) =
          cube[places[static_cast<std::size_t>(i)]] + shift + (i % 2 == 0 ? noise : -noise);
    }
  }

  std::vector<SimilarCubes> found(std::int32_t most, bool is_up_to_mean = false) {
    NoProgress progress;
    return similar_cubes(voxels_, size_, {most, is_up_to_mean}, progress);
  }

  static std::uint64_t count(const std::vector<SimilarCubes>& levels) {
    std::uint64_t all = 0;
    for (const SimilarCubes& level : levels) all += level.references.size();
    return all;
  }

  Size3 size_ = {64, 48, 36};
  std::vector<std::int32_t> voxels_;
};

TEST_F(SimilarCubesTest, NoiseHasNone) {
  EXPECT_EQ(count(found(0)), 0u);
  EXPECT_EQ(count(found(50)), 0u);
  EXPECT_EQ(count(found(50, true)), 0u);
}

TEST_F(SimilarCubesTest, FindsEachCopyOnceAtItsSide) {
  copy({0, 0, 0}, {48, 32, 16}, 16, 17, 0, 0);
  copy({16, 8, 0}, {40, 8, 24}, 8, 44, 0, 0);
  copy({4, 16, 8}, {60, 4, 32}, 4, 5, 0, 0);
  const auto levels = found(0);
  ASSERT_EQ(levels.size(), 3u);
  const Index3 expected[] = {{48, 32, 16}, {40, 8, 24}, {60, 4, 32}};
  for (std::size_t i = 0; i < 3; ++i) {
    ASSERT_EQ(levels[i].references.size(), 1u) << i;
    EXPECT_EQ(levels[i].references[0].corner, expected[i]);
    EXPECT_TRUE(levels[i].references[0].is_turned);
    EXPECT_FALSE(levels[i].references[0].is_coarser);
    EXPECT_GT(levels[i].reference_bits, 10);
  }
  EXPECT_EQ(levels[2].cubes, 16u * 12 * 9);
  EXPECT_EQ(levels[0].cubes, 4u * 3 * 2);
}

TEST_F(SimilarCubesTest, CountsDifferencesAndMeans) {
  copy({0, 0, 0}, {40, 40, 24}, 8, 21, 6, 0);
  EXPECT_EQ(count(found(5)), 0u);
  EXPECT_EQ(count(found(6)), 1u);
  copy({8, 0, 0}, {32, 40, 24}, 8, 30, 6, 900);
  EXPECT_EQ(count(found(6)), 1u);
  EXPECT_EQ(count(found(6, true)), 2u);
}

TEST_F(SimilarCubesTest, FindsTheHalvedOneOfTheNextLevel) {
  for (int i = 0; i < 512; ++i) {
    const Index3 p = {i % 8, i / 8 % 8, i / 64};
    std::int64_t total = 0;
    for (int j = 0; j < 8; ++j) total += at(16 + 2 * p.x + (j & 1), 2 * p.y + (j >> 1 & 1),
                                           2 * p.z + (j >> 2));
    at(56 + p.x, 40 + p.y, 24 + p.z) = static_cast<std::int32_t>((2 * total + 8) / 16);
  }
  const auto levels = found(0);
  ASSERT_EQ(levels[1].references.size(), 1u);
  EXPECT_TRUE(levels[1].references[0].is_coarser);
  EXPECT_EQ(levels[1].references[0].corner, (Index3{56, 40, 24}));
}

TEST_F(SimilarCubesTest, UniformCubesNeedNoReference) {
  std::fill(voxels_.begin(), voxels_.end(), 7);
  const auto levels = found(3);
  EXPECT_EQ(count(levels), 0u);
  EXPECT_EQ(levels[2].uniform, levels[2].cubes);
  EXPECT_EQ(levels[2].asked, 0u);
}

TEST_F(SimilarCubesTest, ChainsOfCopiesReferToOneThatIsKept) {
  // Each differs from the last by 4: the third from the first by 8.
  copy({0, 0, 0}, {16, 0, 0}, 8, 0, 0, 4);
  copy({16, 0, 0}, {16, 16, 0}, 8, 0, 0, 4);
  EXPECT_EQ(found(4)[1].references.size(), 1u);
  EXPECT_EQ(found(8)[1].references.size(), 2u);
}

TEST_F(SimilarCubesTest, ThreadsChangeNothing) {
  for (int i = 0; i < 20; ++i) {
    copy({(i % 4) * 4, 0, 0}, {(i % 16) * 4, 20 + i / 16 * 8, 28}, 4, i, 1, i);
  }
  std::vector<std::uint64_t> counts;
  for (const int threads : {1, 4}) {
    tbb::task_arena arena(threads);
    arena.execute([&] { counts.push_back(count(found(1, true))); });
  }
  EXPECT_EQ(counts[0], counts[1]);
  EXPECT_GE(counts[0], 16u);
}

}  // namespace
}  // namespace octavo
