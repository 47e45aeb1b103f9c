#include "octavo/codec/label/label_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace octavo {
namespace {

constexpr LabelCell kUntouched = label_cell(999, kParent);

template <class Visit>
void visit_cells(const Size3& size, Visit visit) {
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) visit(Index3{x, y, z});
    }
  }
}

struct Parents {
  LabelGrid grid;
  MixedRows mixed;
};

/// Uniform cells of random labels; those at `places` are mixed.
Parents parents_with(const Size3& size, const std::vector<Index3>& places) {
  Parents parents;
  parents.grid.reset(size);
  parents.mixed.resize(static_cast<std::size_t>(size.y * size.z));
  std::mt19937 random(5);
  visit_cells(size, [&](const Index3& at) {
    *parents.grid.at(at) = label_cell(static_cast<std::uint32_t>(random() % 9), kUniform);
  });
  for (const Index3& at : places) {
    *parents.grid.at(at) = label_cell(static_cast<std::uint32_t>(random() % 9), kMixed);
    parents.mixed[static_cast<std::size_t>(size.y * at.z + at.y)] |= std::uint64_t{1} << at.x;
  }
  return parents;
}

LabelGrid expanded_near_mixed(const Parents& parents, const Size3& size) {
  LabelGrid grid;
  grid.reset(size);
  visit_cells(size, [&](const Index3& at) { *grid.at(at) = kUntouched; });
  expand_near_mixed(parents.grid, parents.mixed, size, grid);
  return grid;
}

/// Compares all cells that lie at most two steps from the children of `place`.
void expect_same_near(const LabelGrid& grid, const LabelGrid& expected, const Index3& place) {
  visit_cells({6, 6, 6}, [&](const Index3& step) {
    Index3 at;
    bool is_inside = true;
    for (int axis = 0; axis < 3; ++axis) {
      // Cells beyond the border are outside on either side.
      at[axis] = 2 * place[axis] - 2 + step[axis];
      is_inside = is_inside && at[axis] < grid.size()[axis] + LabelGrid::kBorder;
    }
    if (is_inside) {
      ASSERT_EQ(*grid.at(at), *expected.at(at)) << at.x << ' ' << at.y << ' ' << at.z;
    }
  });
}

TEST(LabelGrid, IsOutsideAllAroundWhateverItWasBefore) {
  constexpr Size3 kSizes[] = {{8, 8, 8}, {2, 2, 2}, {8, 8, 8}, {3, 7, 1}, {1, 1, 1},  {8, 8, 5},
                              {8, 8, 8}, {9, 2, 3}, {8, 8, 8}, {5, 9, 9}, {9, 16, 8}, {2, 1, 2},
                              {8, 8, 8}, {4, 4, 4}, {9, 16, 8}};
  constexpr std::int64_t kBorder = LabelGrid::kBorder;
  LabelGrid grid;
  for (const Size3& size : kSizes) {
    SCOPED_TRACE(::testing::Message() << size.x << ' ' << size.y << ' ' << size.z);
    grid.reset(size);
    visit_cells(size, [&](const Index3& at) { *grid.at(at) = kUntouched; });
    visit_cells({size.x + 2 * kBorder, size.y + 2 * kBorder, size.z + 2 * kBorder},
                [&](const Index3& p) {
                  const Index3 at{p.x - kBorder, p.y - kBorder, p.z - kBorder};
                  if (box_of(size).contains(at)) return;
                  ASSERT_EQ(*grid.at(at), kOutside) << at.x << ' ' << at.y << ' ' << at.z;
                });
  }
}

TEST(LabelGrid, CellsNearMixedOnesAreThoseOfTheWholeLevel) {
  std::mt19937 random(6);
  for (const Size3& size : {Size3{64, 64, 64}, Size3{63, 2, 33}, Size3{5, 7, 11}, Size3{1, 1, 2}}) {
    const Size3 coarse = halved(size, kHalveAll);
    for (const std::size_t count : {1u, 4u, 60u}) {
      std::vector<Index3> places(count);
      for (Index3& at : places) {
        for (int axis = 0; axis < 3; ++axis) {
          at[axis] = static_cast<std::int64_t>(random()) % coarse[axis];
        }
      }
      const Parents parents = parents_with(coarse, places);
      LabelGrid expected;
      expand(parents.grid, size, kHalveAll, expected);
      const LabelGrid grid = expanded_near_mixed(parents, size);
      ASSERT_EQ(grid.size(), size);
      for (const Index3& at : places) expect_same_near(grid, expected, at);
    }
  }
}

TEST(LabelGrid, CellsFarFromMixedOnesAreLeftOut) {
  const Size3 size{64, 64, 64};
  const LabelGrid grid = expanded_near_mixed(parents_with({32, 32, 32}, {{9, 20, 31}}), size);
  std::int64_t touched = 0;
  visit_cells(size, [&](const Index3& at) { touched += *grid.at(at) != kUntouched ? 1 : 0; });
  EXPECT_EQ(touched, 6 * 6 * 4);
}

}  // namespace
}  // namespace octavo
