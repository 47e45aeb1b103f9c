#include "octavo/io/dicom/jpeg2000_size.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

namespace octavo::testing {
namespace {

/// Start of a codestream of one component.
std::string codestream(const std::array<std::uint32_t, 4>& edges, char across, char down) {
  std::string bytes("\xff\x4f\xff\x51\0\x29\0\0", 8);
  const auto add = [&](std::uint32_t number) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(number >> shift);
  };
  for (const std::uint32_t edge : edges) add(edge);
  for (const std::uint32_t tile : {edges[0], edges[1], 0U, 0U}) add(tile);
  return bytes + std::string("\0\1\x0f", 3) + across + down;
}

std::optional<PictureSize> size_of(const std::string& bytes) {
  return jpeg2000_size(std::as_bytes(std::span(bytes)));
}

TEST(Jpeg2000Size, IsThatOfTheSamples) {
  EXPECT_EQ(size_of(codestream({60000, 300, 0, 0}, 1, 1)), (PictureSize{60000, 300}));
  EXPECT_EQ(size_of(codestream({517, 300, 5, 44}, 1, 1)), (PictureSize{512, 256}));
  // Samples at 6, 9 and 12 across, and at 2 down.
  EXPECT_EQ(size_of(codestream({13, 4, 4, 1}, 3, 2)), (PictureSize{3, 1}));
}

TEST(Jpeg2000Size, IsFoundBehindTheBoxesOfAFile) {
  EXPECT_EQ(size_of("some boxes" + codestream({8, 9, 0, 0}, 1, 1)), (PictureSize{8, 9}));
}

TEST(Jpeg2000Size, OfBytesThatSayNoneIsNone) {
  const std::string whole = codestream({8, 9, 0, 0}, 1, 1);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_EQ(size_of(whole.substr(0, length)), std::nullopt) << length;
  }
  EXPECT_EQ(size_of(codestream({8, 9, 0, 0}, 0, 1)), std::nullopt);
  EXPECT_EQ(size_of(codestream({8, 9, 9, 0}, 1, 1)), (PictureSize{0, 9}));
}

}  // namespace
}  // namespace octavo::testing
