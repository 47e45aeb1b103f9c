#include "octavo/codec/entropy/binary_coder.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace octavo {
namespace {

TEST(BinaryCoder, DecisionsComeBackAndAllBytesAreConsumed) {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    std::mt19937 random(seed);
    const std::size_t count = random() % 3000;
    std::vector<bool> bits(count);
    std::vector<Probability> odds(count);
    for (std::size_t i = 0; i < count; ++i) {
      odds[i] = seed % 3 == 0   ? static_cast<Probability>(1 + random() % 65535)
                : seed % 3 == 1 ? 65535
                                : 1;
      bits[i] = random() % 65536 < odds[i];
      if (seed % 7 == 0) bits[i] = !bits[i];
    }
    std::vector<std::uint8_t> bytes;
    BinaryEncoder encoder(bytes);
    for (std::size_t i = 0; i < count; ++i) encoder.put(bits[i], odds[i]);
    encoder.finish();
    BinaryDecoder decoder(bytes);
    for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(decoder.get(odds[i]), bits[i]);
    EXPECT_TRUE(decoder.is_consumed());
  }
}

TEST(BinaryCoder, ReadingPastTheEndIsNoticed) {
  const std::vector<std::uint8_t> bytes = {1, 2, 3, 4, 5};
  BinaryDecoder decoder(bytes);
  for (int i = 0; i < 100; ++i) decoder.get(kEvenOdds);
  EXPECT_TRUE(decoder.is_overrun());
}

}  // namespace
}  // namespace octavo
