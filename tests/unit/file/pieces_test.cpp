#include "octavo/file/pieces.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

Bytes bytes_of(ByteSpan span) { return {span.begin(), span.end()}; }

TEST(Pieces, SegmentsComeBackFromTheirPieces) {
  const std::vector<Bytes> all = {Bytes(300, 1), Bytes(200, 2), {}, Bytes(130, 4), {}, Bytes(3, 6)};
  for (int level_count = 1; level_count <= kTierLevels; ++level_count) {
    const auto levels = static_cast<std::size_t>(level_count);
    std::vector<Bytes> segments(all.begin(), all.begin() + level_count);
    segments.back() = Bytes(5, 9);
    const auto count = static_cast<std::size_t>(piece_count(level_count));
    EXPECT_EQ(count, std::min<std::size_t>(levels, 4));
    const std::array<Bytes, kTierPieces> pieces = encode_pieces(segments);
    for (std::size_t i = 0; i + 1 < count; ++i) EXPECT_EQ(pieces[i], segments[i]) << i;
    for (std::size_t i = count; i < pieces.size(); ++i) EXPECT_TRUE(pieces[i].empty()) << i;
    const auto found = segments_of(std::span(pieces).first(count), level_count);
    for (std::size_t i = 0; i < levels; ++i) EXPECT_EQ(bytes_of(found[i]), segments[i]) << i;
  }
}

TEST(Pieces, AStoredBrickHasNoCoarseOnes) {
  std::vector<Bytes> segments(kTierLevels);
  segments.front() = Bytes(64, 1);
  const std::array<Bytes, kTierPieces> pieces = encode_pieces(segments);
  EXPECT_EQ(pieces[0], segments[0]);
  for (std::size_t i = 1; i < pieces.size(); ++i) EXPECT_TRUE(pieces[i].empty()) << i;
  const auto found = segments_of(pieces, kTierLevels);
  EXPECT_EQ(found[0].size(), 64u);
  for (std::size_t i = 1; i < found.size(); ++i) EXPECT_TRUE(found[i].empty());
}

TEST(Pieces, NoneHoldsCoarseSegmentsWithoutTheCoarsest) {
  std::vector<Bytes> segments(kTierLevels, Bytes(2, 1));
  segments.back().clear();
  EXPECT_THROW(encode_pieces(segments), Error);
}

TEST(Pieces, ThoseThatDoNotHoldTheirSegmentsAreRejected) {
  const Bytes bad[] = {
      {2, 1, 7},           // shorter than the lengths in it
      {2, 1, 7, 7, 8},     // nothing is left for the coarsest samples
      {0},                 // one length
      {0x80, 0, 0, 9},     // a length in more bytes than it needs
      {0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 1, 0, 9},
  };
  for (const Bytes& piece : bad) {
    const std::vector<Bytes> pieces = {{}, {}, {}, piece};
    EXPECT_THROW(segments_of(pieces, kTierLevels), Error);
  }
}

}  // namespace
}  // namespace octavo
