#include "octavo/core/memory_limit.h"

#include <gtest/gtest.h>

#include <string>

#include "octavo/core/error.h"

namespace octavo {
namespace {

std::string rejection(std::uint64_t needed, std::uint64_t limit) {
  try {
    require_memory_within(needed, limit, "the mask", "take less");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    return error.detail();
  }
  return "";
}

TEST(MemoryLimit, RejectsWhatIsAboveItAndNamesBothNumbers) {
  constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
  EXPECT_EQ(rejection(500 * kMiB + 1, 64 * kMiB),
            "the mask would take about 501 MiB of memory; the limit is 64 MiB; take less");
  EXPECT_EQ(rejection(12 * 1024, 1000),
            "the mask would take about 12 KiB of memory; the limit is 1000 bytes; take less");
  EXPECT_EQ(rejection(20 * 1024 * kMiB, 2 * 1024 * kMiB),
            "the mask would take about 20 GiB of memory; the limit is 2048 MiB; take less");
}

TEST(MemoryLimit, AllowsWhatFitsAndEverythingWithoutALimit) {
  EXPECT_EQ(rejection(1000, 1000), "");
  EXPECT_EQ(rejection(~std::uint64_t{0}, 0), "");
}

}  // namespace
}  // namespace octavo
