#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "octavo/codec/entropy/binary_coder.h"
#include "octavo/codec/entropy/byte_io.h"
#include "octavo/codec/grey/grey_model.h"
#include "octavo/core/crc32c.h"

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

TEST(Tokens, EveryValueFitsItsToken) {
  for (std::uint32_t value = 0; value < (1u << grey::kEscapeBits); value += value < 5000 ? 1 : 37) {
    const grey::Token token = grey::token_shape(grey::token_of(value));
    ASSERT_GE(value, token.base);
    ASSERT_LT(value - token.base, 1u << token.bits);
    ASSERT_NE(token.token, grey::kEscapeToken);
  }
}

/// Every frequency, at states around the multiples of it and at the ends of what it is pushed onto.
TEST(Encoder, PushesAsADivisionWould) {
  for (std::uint32_t frequency = 1; frequency <= grey::kTableSize; ++frequency) {
    const std::uint32_t first = frequency < grey::kTableSize ? 1 : 0;
    const grey::Encoder encoder = grey::encoder_of(frequency, first);
    const std::uint64_t end = std::uint64_t{frequency} << 21;
    for (const std::uint64_t near : {std::uint64_t{1} << 16, end, end / 2, end - end / 3}) {
      for (std::uint64_t x = near - std::min<std::uint64_t>(near, 3); x < std::min(near + 3, end);
           ++x) {
        const std::uint64_t expected = (x / frequency << 11) + x % frequency + first;
        ASSERT_EQ(encoder.pushed(static_cast<std::uint32_t>(x)), expected) << frequency << " " << x;
      }
    }
  }
}

TEST(GreyModel, DefaultsSurviveTheirFileForm) {
  const grey::Parameters p = grey::default_parameters();
  const Bytes bytes = grey::serialize(p);
  EXPECT_EQ(grey::serialize(grey::parse_parameters(bytes)), bytes);
}

TEST(GreyModel, WhatNoEncoderWritesIsCorrupt) {
  using grey::Parameters;
  const auto is_accepted = [](void (*change)(Parameters&)) {
    Parameters p = grey::default_parameters();
    change(p);
    try {
      grey::parse_parameters(grey::serialize(p));
      return true;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      return false;
    }
  };
  constexpr std::int64_t kSteps = grey::kMaxVoxelStep;
  using Change = void (*)(Parameters&);
  const Change good[] = {
      [](Parameters& p) { p.quantizer = {3, 0, 0}; },
      [](Parameters& p) { p.quantizer = {kSteps, 0, 0}; },
      [](Parameters& p) { p.quantizer = {1, grey::kMaxDetailStep, kSteps}; },
      [](Parameters& p) { p.value_map.lattice = {16, 15}; },
      [](Parameters& p) { p.has_edges = true; },
      [](Parameters& p) { p.axis_order = {2, 1, 0}; },
      [](Parameters& p) { p.activity_threshold = 1; },
      [](Parameters& p) { p.activity_threshold = grey::kMaxThreshold; },
      [](Parameters& p) { p.weight_step = 8; },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.mean_weights[0][0][1] = -grey::kMaxMeanWeight;
      },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.mean_weights[1][2][1] = grey::kMaxMeanWeight;
      },
      [](Parameters& p) { p.context_weights[0][0][1] = 8191; },
  };
  for (std::size_t i = 0; i < std::size(good); ++i) EXPECT_TRUE(is_accepted(good[i])) << i;
  const Change bad[] = {
      // Steps: even, too large, of both sorts, of details without corrections, of those alone.
      [](Parameters& p) { p.quantizer = {2, 0, 0}; },
      [](Parameters& p) { p.quantizer = {kSteps + 2, 0, 0}; },
      [](Parameters& p) { p.quantizer = {1, grey::kMaxDetailStep + 1, 1}; },
      [](Parameters& p) { p.quantizer = {1, 9, kSteps + 1}; },
      [](Parameters& p) { p.quantizer = {3, 9, 1}; },
      [](Parameters& p) { p.quantizer = {1, 9, 0}; },
      [](Parameters& p) { p.quantizer = {3, 0, 1}; },
      // Maps and edges belong to lossless models.
      [](Parameters& p) {
        p.quantizer = {3, 0, 0};
        p.value_map.lattice = {16, 15};
      },
      [](Parameters& p) {
        p.quantizer = {3, 0, 0};
        p.has_edges = true;
      },
      [](Parameters& p) { p.activity_threshold = 0; },
      [](Parameters& p) { p.activity_threshold = grey::kMaxThreshold + 1; },
      [](Parameters& p) { p.weight_step = 9; },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.mean_weights[0][0][1] = -grey::kMaxMeanWeight - 1;
      },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.mean_weights[1][2][1] = grey::kMaxMeanWeight + 1;
      },
      [](Parameters& p) { p.context_weights[0][0][1] = 8192; },
      [](Parameters& p) { p.frequencies[0][0][0] = grey::kTableSize; },
  };
  for (std::size_t i = 0; i < std::size(bad); ++i) EXPECT_FALSE(is_accepted(bad[i])) << i;
}

TEST(GreyModel, FlagsWithoutMeaningAreCorrupt) {
  const Bytes good = grey::serialize(grey::default_parameters());
  const auto expect_corrupt = [&](std::uint8_t flags, const Bytes& inserted) {
    Bytes bytes = good;
    bytes[0] |= flags;
    bytes.insert(bytes.begin() + 1, inserted.begin(), inserted.end());
    EXPECT_THROW(grey::parse_parameters(bytes), Error) << int{flags};
  };
  expect_corrupt(128, {});
  expect_corrupt(6 << 2, {});      // an order of axes that does not exist
  expect_corrupt(2, {1, 0, 0});    // a maximum error that changes nothing
  expect_corrupt(32, {1, 0, 0});   // a map of values that says nothing
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_THROW(grey::parse_parameters(longer), Error);
}

TEST(GreyModel, EveryTruncationIsRejected) {
  const Bytes bytes = grey::serialize(grey::default_parameters());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THROW(grey::parse_parameters(ByteSpan(bytes).first(length)), Error) << length;
  }
}

}  // namespace
}  // namespace octavo
