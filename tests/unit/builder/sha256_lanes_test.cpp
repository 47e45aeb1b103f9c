#include "octavo/builder/sha256_lanes.h"

#include <gtest/gtest.h>

#include <random>

#include "octavo/core/sha256.h"

namespace octavo {
namespace {

// What is added to each run: so many bytes, zeros or others.
struct AddedPart {
  std::size_t byte_count;
  bool is_zero;
};

void expect_portable_digests_by(bool by_instructions, std::size_t lane_count,
                                const std::vector<AddedPart>& parts, ZeroStates& zero_states) {
  std::mt19937 random(5);
  Sha256Lanes lanes(lane_count, zero_states, by_instructions);
  std::vector<Sha256> expected(lane_count);
  for (const AddedPart& part : parts) {
    Bytes bytes(lane_count * part.byte_count);
    if (!part.is_zero) {
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
      lanes.add(bytes);
    } else {
      lanes.add_zeros(part.byte_count);
    }
    for (std::size_t i = 0; i < lane_count; ++i) {
      expected[i].add(ByteSpan(bytes).subspan(i * part.byte_count, part.byte_count));
    }
  }
  const std::vector<Sha256Digest> digests = lanes.digests();
  ASSERT_EQ(digests.size(), lane_count);
  for (std::size_t i = 0; i < lane_count; ++i) {
    ASSERT_EQ(digests[i], expected[i].digest()) << i << " of " << lane_count;
  }
}

void expect_portable_digests(std::size_t lane_count, const std::vector<AddedPart>& parts,
                             ZeroStates& zero_states) {
  expect_portable_digests_by(false, lane_count, parts, zero_states);
  if (Sha256Lanes::is_native()) expect_portable_digests_by(true, lane_count, parts, zero_states);
}

TEST(Sha256Lanes, AgreeWithThePortableOneAtEveryLength) {
  ZeroStates zero_states;
  for (std::size_t length = 0; length < 200; ++length) {
    for (const bool is_zero : {false, true}) {
      expect_portable_digests(length % 5 + 1, {{length, is_zero}}, zero_states);
    }
  }
}

TEST(Sha256Lanes, TakeZerosBeforeAndBetweenOtherBytes) {
  ZeroStates zero_states;
  for (std::size_t length = 0; length < 200; length += 3) {
    expect_portable_digests(3, {{length, true}, {length / 2, false}, {70, true}, {9, false}},
                            zero_states);
  }
  expect_portable_digests(2, {{16384, true}, {100000, true}, {1, false}, {140000, true}},
                          zero_states);
}

TEST(Sha256Lanes, HaveTheStateBehindZerosWhateverWasAskedBefore) {
  if (!Sha256Lanes::is_native()) GTEST_SKIP() << "a processor without instructions of SHA";
  for (const std::uint64_t first : {0u, 300u, 2000u}) {
    ZeroStates asked;
    asked.after(first);
    for (const std::uint64_t count : {0u, 1u, 255u, 256u, 257u, 600u}) {
      ZeroStates fresh;
      EXPECT_EQ(asked.after(count), fresh.after(count)) << count << " after " << first;
    }
  }
}

}  // namespace
}  // namespace octavo
