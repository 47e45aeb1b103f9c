#include "octavo/core/joined_sets.h"

#include <gtest/gtest.h>

#include <cstdint>

namespace octavo {
namespace {

TEST(JoinedSets, TheSmallestMemberStandsForASet) {
  JoinedSets<std::uint32_t> sets(8);
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(sets.first_of(i), i);
  sets.join(7, 5);
  sets.join(3, 6);
  sets.join(6, 7);
  sets.join(5, 3);
  for (const std::uint32_t member : {3u, 5u, 6u, 7u}) EXPECT_EQ(sets.first_of(member), 3u);
  for (const std::uint32_t member : {0u, 1u, 2u, 4u}) EXPECT_EQ(sets.first_of(member), member);
  sets.join(5, 0);
  for (const std::uint32_t member : {0u, 3u, 5u, 6u, 7u}) EXPECT_EQ(sets.first_of(member), 0u);
  EXPECT_EQ(sets.first_of(4), 4u);
}

TEST(JoinedSets, MoreNumbersAreSetsOfTheirOwnAndFewerChangeNothing) {
  JoinedSets<std::uint32_t> sets;
  sets.grow_to(3);
  sets.join(2, 1);
  sets.grow_to(6);
  sets.grow_to(2);
  sets.join(5, 2);
  for (const std::uint32_t member : {1u, 2u, 5u}) EXPECT_EQ(sets.first_of(member), 1u);
  for (const std::uint32_t member : {0u, 3u, 4u}) EXPECT_EQ(sets.first_of(member), member);
}

}  // namespace
}  // namespace octavo
