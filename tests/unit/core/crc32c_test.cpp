#include "octavo/core/crc32c.h"

#include <gtest/gtest.h>

#include <random>
#include <span>
#include <vector>

namespace octavo {
namespace {

std::vector<std::uint8_t> random_bytes(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::uint8_t> bytes(count);
  for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
  return bytes;
}

TEST(Crc32c, KnownAnswersOfRfc3720) {
  const std::vector<std::uint8_t> zeros(32, 0), ones(32, 0xff);
  EXPECT_EQ(crc32c(zeros), 0x8a9136aau);
  EXPECT_EQ(crc32c(ones), 0x62a8ab43u);
}

TEST(Crc32c, InstructionAndTableAgreeAtEveryLengthAndAlignment) {
  const auto bytes = random_bytes(200, 3);
  for (std::size_t start = 0; start < 9; ++start) {
    for (std::size_t length = 0; start + length <= 100; ++length) {
      const auto part = std::span(bytes).subspan(start, length);
      ASSERT_EQ(crc32c(part), crc32c_portable(part));
    }
  }
}

TEST(Crc32c, InstructionAndTableAgreeWhereLanesBeginAndEnd) {
  constexpr std::size_t kBlockBytes = std::size_t{3} * 4096;
  const auto bytes = random_bytes(3 * kBlockBytes + 100, 6);
  for (const std::size_t block : {kBlockBytes, 2 * kBlockBytes, 3 * kBlockBytes}) {
    for (std::size_t length = block - 17; length < block + 18; ++length) {
      const auto part = std::span(bytes).subspan(length % 9, length);
      ASSERT_EQ(crc32c(part, 0x12345678u), crc32c_portable(part, 0x12345678u)) << length;
    }
  }
}

TEST(Crc32c, ContinuesWhereItStopped) {
  const auto bytes = random_bytes(1000, 4);
  const auto all = std::span<const std::uint8_t>(bytes);
  EXPECT_EQ(crc32c(all.subspan(333), crc32c(all.first(333))), crc32c(all));
}

TEST(Crc32c, OfTwoPartsIsJoinedFromBoth) {
  const auto bytes = random_bytes(70000, 5);
  const auto all = std::span<const std::uint8_t>(bytes);
  for (const std::size_t cut : {std::size_t{0}, std::size_t{1}, std::size_t{333},
                                std::size_t{69999}, bytes.size()}) {
    const auto end = all.subspan(cut);
    EXPECT_EQ(crc32c_joined(crc32c(all.first(cut)), crc32c(end), crc32c_shift(end.size())),
              crc32c(all));
  }
}

}  // namespace
}  // namespace octavo
