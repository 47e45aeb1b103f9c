#include "octavo/threads/ordered_pipeline.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "octavo/threads/arena.h"

namespace octavo {
namespace {

TEST(OrderedPipeline, KeepsInOrderWhatThreadsMake) {
  std::vector<std::size_t> kept;
  run_in_arena(4, [&] {
    // A type that is moved alone.
    ordered_pipeline(1000, 8, [](std::size_t i) { return std::make_unique<std::size_t>(i); },
                     [&](std::unique_ptr<std::size_t> made) { kept.push_back(*made); });
  });
  ASSERT_EQ(kept.size(), 1000U);
  for (std::size_t i = 0; i < kept.size(); ++i) ASSERT_EQ(kept[i], i);
}

TEST(OrderedPipeline, PassesOnWhatIsThrown) {
  const auto make = [](std::size_t i) { return i == 7 ? throw std::runtime_error("made") : i; };
  EXPECT_THROW(ordered_pipeline(20, 4, make, [](std::size_t) {}), std::runtime_error);
  const auto keep = [](std::size_t) { throw std::logic_error("kept"); };
  EXPECT_THROW(ordered_pipeline(3, 4, [](std::size_t i) { return i; }, keep), std::logic_error);
  ordered_pipeline(0, 4, make, keep);
}

}  // namespace
}  // namespace octavo
