#include "octavo/mesh/piece_sets.h"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace octavo {
namespace {

using Blocks = std::vector<std::uint32_t>;

TEST(PieceSets, WhatWaitsForAPieceWaitsForAllThatIsJoinedToIt) {
  PieceSets sets;
  sets.grow_to(4);
  sets.note(0, 7);
  sets.note(1, 3);
  sets.note(1, 7);
  sets.note(2, 5);
  sets.join(1, 0);
  EXPECT_EQ(sets.take(0), (Blocks{3, 7}));
  EXPECT_EQ(sets.take(1), Blocks{});
  sets.join(2, 0);
  sets.note(1, 9);
  EXPECT_EQ(sets.take(2), (Blocks{5, 9}));
  EXPECT_EQ(sets.take(3), Blocks{});
}

TEST(PieceSets, AreWhatJoiningByHandGives) {
  constexpr std::uint32_t kPoints = 200;
  std::mt19937 random(4);
  PieceSets sets;
  sets.grow_to(kPoints);
  std::vector<std::uint32_t> piece_of(kPoints);
  std::vector<std::set<std::uint32_t>> waiting(kPoints);
  for (std::uint32_t i = 0; i < kPoints; ++i) piece_of[i] = i;
  for (int step = 0; step < 5000; ++step) {
    const auto a = static_cast<std::uint32_t>(random() % kPoints);
    const auto b = static_cast<std::uint32_t>(random() % kPoints);
    if (step % 40 == 0) {
      const std::uint32_t from = piece_of[b];
      for (std::uint32_t& piece : piece_of) piece = piece == from ? piece_of[a] : piece;
      if (from != piece_of[a]) waiting[piece_of[a]].merge(waiting[from]);
      sets.join(a, b);
    } else if (step % 40 == 20) {
      auto& expected = waiting[piece_of[a]];
      EXPECT_EQ(sets.take(a), Blocks(expected.begin(), expected.end()));
      expected.clear();
    } else {
      waiting[piece_of[a]].insert(b);
      sets.note(a, b);
    }
  }
  for (std::uint32_t i = 0; i < kPoints; ++i) {
    EXPECT_EQ(sets.first_of(i) == sets.first_of(0), piece_of[i] == piece_of[0]);
  }
}

TEST(PieceSets, TakingOnePieceDoesNotVisitWhatWaitsForOthers) {
  constexpr std::uint32_t kWaves = 1000;
  constexpr std::uint32_t kOthers = 50;  // of a wave; they go on, but not with piece 0
  PieceSets sets;
  sets.grow_to(1);
  for (std::uint32_t wave = 0; wave < kWaves; ++wave) {
    const std::uint32_t first = 1 + wave * kOthers;
    sets.grow_to(first + kOthers);
    for (std::uint32_t i = 0; i < kOthers; ++i) sets.note(first + i, 2 * wave + 1);
    sets.note(0, 2 * wave);
    EXPECT_EQ(sets.take(0), Blocks{2 * wave});
  }
  EXPECT_LE(sets.steps(), 3 * kWaves * (kOthers + 1));
}

TEST(PieceSets, JoiningMovesTheShorterList) {
  constexpr std::uint32_t kPieces = 4096;
  PieceSets sets;
  sets.grow_to(kPieces);
  for (std::uint32_t i = 0; i < kPieces; ++i) sets.note(i, i);
  // The long list of the last piece grows by one at a time.
  for (std::uint32_t i = kPieces - 1; i > 0; --i) sets.join(i, i - 1);
  EXPECT_EQ(sets.take(0).size(), kPieces);
  EXPECT_LE(static_cast<double>(sets.steps()), 6.0 * kPieces);
}

}  // namespace
}  // namespace octavo
