#include "octavo/octree/o_code.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "octavo/core/error.h"

namespace octavo {
namespace {

// The definition, bit by bit.
std::uint64_t slow_code(const Index3& p) {
  std::uint64_t code = 0;
  for (int i = 20; i >= 0; --i) {
    const auto digit = 4 * (p.z >> i & 1) + 2 * (p.x >> i & 1) + (p.y >> i & 1);
    code = 8 * code + static_cast<std::uint64_t>(digit);
  }
  return code;
}

TEST(OCode, DigitIsFourZPlusTwoXPlusY) {
  for (std::int64_t z = 0; z < 16; ++z)
    for (std::int64_t y = 0; y < 16; ++y)
      for (std::int64_t x = 0; x < 16; ++x) EXPECT_EQ(interleave({x, y, z}), slow_code({x, y, z}));
  EXPECT_EQ(interleave({1, 0, 0}), 2u);
  EXPECT_EQ(interleave({0, 1, 0}), 1u);
  EXPECT_EQ(interleave({0, 0, 1}), 4u);
}

TEST(OCode, EveryBitOfEveryAxisGoesThereAndBack) {
  for (int i = 0; i < kMaxUniverseLevel; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      Index3 p;
      p[axis] = std::int64_t{1} << i;
      EXPECT_EQ(interleave(p), slow_code(p));
      EXPECT_EQ(deinterleave(interleave(p)), p);
    }
  }
  const std::int64_t last = (std::int64_t{1} << 21) - 1;
  EXPECT_EQ(interleave({last, last, last}), (std::uint64_t{1} << 63) - 1);
  EXPECT_EQ(deinterleave((std::uint64_t{1} << 63) - 1), (Index3{last, last, last}));
}

TEST(OCode, UniverseIsTheSmallestPowerOfTwo) {
  EXPECT_EQ(universe_level({1, 1, 1}), 0);
  EXPECT_EQ(universe_level({2, 1, 1}), 1);
  EXPECT_EQ(universe_level({1, 3, 1}), 2);
  EXPECT_EQ(universe_level({256, 256, 108}), 8);
  EXPECT_EQ(universe_level({1, 1, 257}), 9);
  EXPECT_EQ(universe_level({std::int64_t{1} << 21, 1, 1}), 21);
  EXPECT_THROW(universe_level({(std::int64_t{1} << 21) + 1, 1, 1}), Error);
  EXPECT_THROW(universe_level({0, 1, 1}), Error);
}

TEST(OCode, CodesBeyondTheUniverseAreInvalid) {
  EXPECT_TRUE(is_valid({0, 511}, 3));
  EXPECT_FALSE(is_valid({0, 512}, 3));
  EXPECT_TRUE(is_valid({3, 0}, 3));
  EXPECT_FALSE(is_valid({3, 1}, 3));
  EXPECT_FALSE(is_valid({4, 0}, 3));
  EXPECT_FALSE(is_valid({-1, 0}, 3));
  EXPECT_TRUE(is_valid({0, (std::uint64_t{1} << 63) - 1}, 21));
  EXPECT_FALSE(is_valid({0, std::uint64_t{1} << 63}, 21));
  EXPECT_FALSE(is_valid({0, 0}, 22));
  EXPECT_FALSE(is_valid({0, 0}, -1));
}

TEST(OCode, ChildrenAreTheEightCubesInsideInOrder) {
  const OCode cube{2, 0123};
  const std::array<OCode, 8> children = children_of(cube);
  for (int octant = 0; octant < 8; ++octant) {
    const OCode& child = children[static_cast<std::size_t>(octant)];
    EXPECT_EQ(octant_of(child), octant);
    EXPECT_EQ(parent_of(child), cube);
    EXPECT_TRUE(contains(cube, child));
    EXPECT_FALSE(contains(child, cube));
    EXPECT_TRUE(box_of(cube).contains(box_of(child)));
  }
  EXPECT_FALSE(contains(cube, OCode{1, 01240}));
}

TEST(OCode, NotationsAreThoseOfTheThesis) {
  const OCode cube = cube_at({0, 2, 4}, 1);
  EXPECT_EQ(to_mixed_octal(cube, 3), "418");
  EXPECT_EQ(to_hierarchical(cube, 3), "41");
  EXPECT_EQ(to_mixed_octal({3, 0}, 3), "888");
  EXPECT_EQ(to_hierarchical({3, 0}, 3), "");
  EXPECT_EQ(to_mixed_octal({0, 0}, 0), "");
  EXPECT_EQ(corner_of(cube), (Index3{0, 2, 4}));
  EXPECT_EQ(box_of(cube), (Box{{0, 2, 4}, {2, 4, 6}}));
}

TEST(OCode, TextsLeadBackToTheirCubes) {
  const int n = 3;
  for (int level = 0; level <= n; ++level) {
    for (std::uint64_t code = 0; code < cube_volume(n - level); ++code) {
      const OCode cube{level, code};
      EXPECT_EQ(parse_mixed_octal(to_mixed_octal(cube, n)), cube);
      EXPECT_EQ(parse_hierarchical(to_hierarchical(cube, n), n), cube);
    }
  }
}

TEST(OCode, BadTextIsRejected) {
  for (const char* text : {"9", "8x", "81", "0 1", "-1", "4180", "0000000000000000000000"}) {
    EXPECT_THROW(parse_mixed_octal(text), Error) << text;
  }
  for (const char* text : {"8", "418", "0000", "a", "+1"}) {
    EXPECT_THROW(parse_hierarchical(text, 3), Error) << text;
  }
  EXPECT_THROW(parse_hierarchical("", 22), Error);
  EXPECT_THROW(parse_hierarchical("", -1), Error);
  try {
    parse_mixed_octal("81");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_NE(std::string(error.what()).find("'81'"), std::string::npos);
  }
}

TEST(OCode, DirectionsAreFacesThenEdgesThenCorners) {
  std::set<std::array<int, 3>> seen;
  for (std::size_t i = 0; i < kDirections.size(); ++i) {
    const Direction d = kDirections[i];
    const int kind = d.x * d.x + d.y * d.y + d.z * d.z;
    EXPECT_EQ(kind, i < 6 ? 1 : i < 18 ? 2 : 3);
    seen.insert({d.x, d.y, d.z});
  }
  EXPECT_EQ(seen.size(), 26u);
}

TEST(OCode, NeighborsOfEveryCubeOfASmallUniverseAreThoseOfItsCoordinates) {
  const int n = 3;
  for (int level = 0; level <= n; ++level) {
    const std::int64_t side = std::int64_t{1} << (n - level);
    for (std::uint64_t code = 0; code < cube_volume(n - level); ++code) {
      const Index3 p = deinterleave(code);
      const auto all = neighbors_of({level, code}, n);
      for (std::size_t i = 0; i < kDirections.size(); ++i) {
        const Direction& d = kDirections[i];
        const Index3 q{p.x + d.x, p.y + d.y, p.z + d.z};
        const auto found = neighbor_of({level, code}, d, n);
        EXPECT_EQ(found, all[i]);
        if (box_of(Size3{side, side, side}).contains(q)) {
          EXPECT_EQ(found, (OCode{level, interleave(q)}));
        } else {
          EXPECT_FALSE(found.has_value());
        }
      }
    }
  }
}

TEST(OCode, SortingMixedOctalTextIsPostOrder) {
  const int n = 2;
  std::vector<OCode> cubes;
  for (int level = 0; level <= n; ++level)
    for (std::uint64_t code = 0; code < cube_volume(n - level); ++code)
      cubes.push_back({level, code});
  std::vector<std::string> texts;
  for (const OCode& cube : cubes) texts.push_back(to_mixed_octal(cube, n));
  std::sort(texts.begin(), texts.end());
  std::sort(cubes.begin(), cubes.end(), is_before_in_post_order);
  for (std::size_t i = 0; i < cubes.size(); ++i) EXPECT_EQ(to_mixed_octal(cubes[i], n), texts[i]);
  EXPECT_EQ(texts.back(), "88");
}

}  // namespace
}  // namespace octavo
