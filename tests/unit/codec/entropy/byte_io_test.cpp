#include "octavo/codec/entropy/byte_io.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <span>
#include <utility>
#include <vector>

namespace octavo {
namespace {

TEST(Varint, EveryLengthComesBack) {
  for (int shift = 0; shift < 64; ++shift) {
    for (const std::uint64_t value : {std::uint64_t{1} << shift, (std::uint64_t{1} << shift) - 1}) {
      std::vector<std::uint8_t> bytes;
      put_varint(bytes, value);
      std::span<const std::uint8_t> rest = bytes;
      EXPECT_EQ(take_varint(rest), value);
      EXPECT_TRUE(rest.empty());
    }
  }
}

TEST(Varint, TruncatedAndOversizedAreRejected) {
  for (const std::vector<std::uint8_t>& bytes :
       {std::vector<std::uint8_t>{}, std::vector<std::uint8_t>{0x80},
        std::vector<std::uint8_t>{0x81, 0x00},
        std::vector<std::uint8_t>(11, 0xff)}) {
    std::span<const std::uint8_t> rest = bytes;
    EXPECT_THROW(take_varint(rest), Error);
  }
}

TEST(CountedBytes, ComeBackOneAfterTheOther) {
  const std::vector<std::vector<std::uint8_t>> all = {
      {}, {7}, std::vector<std::uint8_t>(300, 0x80), {1, 2}};
  std::vector<std::uint8_t> out;
  for (const auto& bytes : all) put_counted(out, bytes);
  std::span<const std::uint8_t> rest = out;
  for (const auto& bytes : all) EXPECT_TRUE(std::ranges::equal(take_counted(rest), bytes));
  EXPECT_TRUE(rest.empty());
}

TEST(CountedBytes, ThatEndEarlyAreRejected) {
  const std::vector<std::uint8_t> bytes = {3, 1, 2};
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    std::span<const std::uint8_t> rest = std::span(bytes).first(length);
    EXPECT_THROW(take_counted(rest), Error) << length;
  }
}

TEST(BitFields, ComeBackAndTheEndIsKnown) {
  std::mt19937_64 random(11);
  std::vector<std::pair<std::uint64_t, int>> fields;
  for (int i = 0; i < 2000; ++i) {
    const int count = static_cast<int>(random() % 43);
    fields.emplace_back(random() & ((std::uint64_t{1} << count) - 1), count);
  }
  std::vector<std::uint8_t> bytes;
  BitWriter writer(bytes);
  for (const auto& [value, count] : fields) writer.put(value, count);
  writer.finish();
  BitReader reader(bytes);
  for (const auto& [value, count] : fields) ASSERT_EQ(reader.get(count), value);
  EXPECT_TRUE(reader.is_consumed());
}

}  // namespace
}  // namespace octavo
