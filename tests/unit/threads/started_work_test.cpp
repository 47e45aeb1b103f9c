#include "octavo/threads/started_work.h"

#include <gtest/gtest.h>

#include <stdexcept>

#include "octavo/threads/arena.h"

namespace octavo {
namespace {

TEST(StartedWork, IsDoneOnceItWasWaitedForAndThrowsThere) {
  run_in_arena(2, [] {
    int done = 0;
    StartedWork work;
    work.start([&] { ++done; });
    work.wait();
    EXPECT_EQ(done, 1);
    work.start([] { throw std::runtime_error("failed"); });
    EXPECT_THROW(work.wait(), std::runtime_error);
    work.wait();
  });
}

}  // namespace
}  // namespace octavo
