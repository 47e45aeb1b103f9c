#include "octavo/codec/grey/grey_model.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace octavo {
namespace {

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
      [](Parameters& p) {
        p.has_edges = true;
        p.edge_frequencies[9] = {1, 2, grey::kTableSize - 3};
      },
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
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.far_shares[0][0] = -grey::kMaxShare;
        p.far_shares[2][2] = grey::kMaxShare;
        p.behind_weights[0][1][1] = -grey::kMaxShare;
        p.behind_weights[2][0][4] = grey::kMaxShare;
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
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.far_shares[0][0] = -grey::kMaxShare - 1;
      },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.far_shares[2][2] = grey::kMaxShare + 1;
      },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.behind_weights[0][1][1] = -grey::kMaxShare - 1;
      },
      [](Parameters& p) {
        p.predictor = grey::Predictor::means;
        p.behind_weights[2][0][4] = grey::kMaxShare + 1;
      },
      [](Parameters& p) { p.context_weights[0][0][1] = 8192; },
      [](Parameters& p) { p.frequencies[0][0][0] = grey::kTableSize; },
      [](Parameters& p) {
        p.has_edges = true;
        p.edge_frequencies[9] = {0, 2, grey::kTableSize - 2};
      },
  };
  for (std::size_t i = 0; i < std::size(bad); ++i) EXPECT_FALSE(is_accepted(bad[i])) << i;
}

TEST(GreyModel, FlagsThatChangeNothingAreCorruptAndUnknownOnesAreNewer) {
  const Bytes good = grey::serialize(grey::default_parameters());
  const auto kind_of_failure = [&](std::uint8_t flags, const Bytes& inserted) {
    Bytes bytes = good;
    bytes[0] |= flags;
    bytes.insert(bytes.begin() + 2, inserted.begin(), inserted.end());
    try {
      grey::parse_parameters(bytes);
    } catch (const Error& error) {
      return error.kind();
    }
    ADD_FAILURE() << int{flags};
    return ErrorKind::internal;
  };
  EXPECT_EQ(kind_of_failure(128, {}), ErrorKind::unsupported_version);
  EXPECT_EQ(kind_of_failure(6 << 2, {}), ErrorKind::unsupported_version) << "an order of axes";
  EXPECT_EQ(kind_of_failure(2, {1, 0, 0}), ErrorKind::corrupt) << "a maximum error of nothing";
  EXPECT_EQ(kind_of_failure(32, {1, 0, 0}), ErrorKind::corrupt) << "a map that says nothing";
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
