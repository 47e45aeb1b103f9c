// Both plans bring what every rank gives to the first one.
#include "octavo/dist/gather.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>

#include "octavo/core/error.h"
#include "octavo/dist/thread_ranks.h"

namespace octavo {
namespace {

constexpr int kMostGathering = 70;

// Rank r gives r + 1 bytes.
Bytes gift_of(int rank) {
  return Bytes(static_cast<std::size_t>(rank) + 1, static_cast<std::uint8_t>(rank));
}

TEST(Gather, RankZeroGetsWhatEachRankGives) {
  for (const GatherPlan plan : {GatherPlan::tree, GatherPlan::mesh}) {
    for (const int size : {1, 2, 3, 4, 5, 7, 8, 9, 16, 17}) {
      run_thread_ranks(size, [&](Communicator& ranks) {
        const std::vector<Bytes> all = gather(plan, ranks, gift_of(ranks.rank()));
        ASSERT_EQ(all.size(), ranks.is_first() ? static_cast<std::size_t>(size) : 0u);
        for (std::size_t rank = 0; rank < all.size(); ++rank) {
          EXPECT_EQ(all[rank], gift_of(static_cast<int>(rank)));
        }
      });
    }
  }
}

TEST(Gather, EveryRankIsHeardByTheOneItTells) {
  for (const GatherPlan plan : {GatherPlan::tree, GatherPlan::mesh}) {
    for (int size = 1; size <= kMostGathering; ++size) {
      std::size_t heard = 0;
      for (int rank = 0; rank < size; ++rank) {
        for (const int other : steps_of(plan, rank, size).hears) {
          EXPECT_EQ(steps_of(plan, other, size).tells, rank) << size;
          EXPECT_GT(other, rank);
          ++heard;
        }
      }
      EXPECT_EQ(heard, static_cast<std::size_t>(size) - 1);
      EXPECT_EQ(steps_of(plan, 0, size).tells, -1);
    }
  }
}

// Figures 2.8 and 2.9, with I, II, III and IV as ranks 0, 1, 2 and 3.
TEST(Gather, StepsAreThoseOfTheThesis) {
  EXPECT_EQ(steps_of(GatherPlan::tree, 0, 7).hears, (std::vector<int>{1, 2}));
  EXPECT_EQ(steps_of(GatherPlan::tree, 1, 7).hears, (std::vector<int>{3, 4}));
  EXPECT_EQ(steps_of(GatherPlan::mesh, 0, 4).hears, (std::vector<int>{1, 2}));
  EXPECT_EQ(steps_of(GatherPlan::mesh, 2, 4).hears, (std::vector<int>{3}));
  EXPECT_EQ(steps_of(GatherPlan::mesh, 3, 4).tells, 2);
}

TEST(Gather, SumsAreThoseOfTheRanksBefore) {
  run_thread_ranks(5, [](Communicator& ranks) {
    const auto rank = static_cast<std::uint64_t>(ranks.rank());
    const std::vector<std::uint64_t> own = {rank + 1, 100 * rank};
    const RankSums sums = ranks.sum_before(own);
    EXPECT_EQ(sums.before, (std::vector<std::uint64_t>{rank * (rank + 1) / 2,
                                                       100 * rank * (rank - (rank > 0)) / 2}));
    EXPECT_EQ(sums.all, (std::vector<std::uint64_t>{15, 1000}));
  });
}

TEST(Gather, WhoWaitsIsToldThatAnotherFailed) {
  std::atomic<int> waiting = 0;
  const auto work = [&](Communicator& ranks) {
    if (ranks.rank() == 2) throw Error(ErrorKind::io, "no disk");
    try {
      ranks.barrier();
    } catch (const Error& error) {
      waiting += error.kind() == ErrorKind::cancelled ? 1 : 0;
      throw;
    }
  };
  try {
    run_thread_ranks(3, work);
    ADD_FAILURE() << "nothing failed";
  } catch (const Error& error) {
    EXPECT_EQ(error.detail(), "no disk");
  }
  EXPECT_EQ(waiting, 2);
}

}  // namespace
}  // namespace octavo
