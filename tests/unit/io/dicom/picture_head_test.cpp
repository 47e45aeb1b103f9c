#include "octavo/io/dicom/picture_head.h"

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

std::optional<PictureHead> head_of(const std::string& bytes) {
  return picture_head(std::as_bytes(std::span(bytes)));
}

TEST(PictureHead, IsThatOfTheSamples) {
  EXPECT_EQ(head_of(codestream({60000, 300, 0, 0}, 1, 1)), (PictureHead{60000, 300, 16}));
  EXPECT_EQ(head_of(codestream({517, 300, 5, 44}, 1, 1)), (PictureHead{512, 256, 16}));
  // Samples at 6, 9 and 12 across, and at 2 down.
  EXPECT_EQ(head_of(codestream({13, 4, 4, 1}, 3, 2)), (PictureHead{3, 1, 16}));
}

TEST(PictureHead, IsFoundBehindTheBoxesOfAFile) {
  EXPECT_EQ(head_of("some boxes" + codestream({8, 9, 0, 0}, 1, 1)), (PictureHead{8, 9, 16}));
}

TEST(PictureHead, OfBytesThatSayNoneIsNone) {
  const std::string whole = codestream({8, 9, 0, 0}, 1, 1);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_EQ(head_of(whole.substr(0, length)), std::nullopt) << length;
  }
  EXPECT_EQ(head_of(codestream({8, 9, 0, 0}, 0, 1)), std::nullopt);
  EXPECT_EQ(head_of(codestream({8, 9, 9, 0}, 1, 1)), (PictureHead{0, 9, 16}));
}

TEST(PictureHead, OfJpeg2000SaysBitsAndSign) {
  std::string signed_bits = codestream({8, 9, 0, 0}, 1, 1);
  signed_bits[42] = static_cast<char>(0x8b);
  EXPECT_EQ(head_of(signed_bits), (PictureHead{8, 9, 12, true}));
}

TEST(PictureHead, OfJpegIsFoundBehindTables) {
  const std::string start("\xff\xd8\xff\xe0\0\6JFIF\xff\xff\xdb\0\3\0", 16);
  const std::string size("\0\x0b\x0c\1\x2c\2\1\1\1\x11\0", 11);
  EXPECT_EQ(head_of(start + "\xff\xc3" + size), (PictureHead{513, 300, 12}));
  EXPECT_EQ(head_of(start + "\xff\xf7" + size), (PictureHead{513, 300, 12}));
  // A table of codes is no frame, and behind the start of a scan there is none.
  EXPECT_EQ(head_of(start + "\xff\xc4" + size + "\xff\xc3" + size),
            (PictureHead{513, 300, 12}));
  EXPECT_EQ(head_of(start + "\xff\xda" + size), std::nullopt);
  EXPECT_EQ(head_of(start + "\xff\xc3" + size.substr(0, 6)), std::nullopt);
}

TEST(PictureHead, OfLosslessJpegSaysWhereItsBitsStand) {
  const auto place = [](const std::string& bytes) {
    return lossless_bits_place(std::as_bytes(std::span(bytes)));
  };
  const std::string start("\xff\xd8\xff\xfe\0\3\xc3", 7);
  const std::string size("\0\x0b\x0c\1\x2c\2\1\1\1\x11\0", 11);
  EXPECT_EQ(place(start + "\xff\xc3" + size), 11U);
  for (const char* mark : {"\xff\xc0", "\xff\xc2", "\xff\xf7", "\xff\xda"}) {
    EXPECT_EQ(place(start + mark + size), std::nullopt);
  }
  EXPECT_EQ(place(start + "\xff\xc3" + size.substr(0, 6)), std::nullopt);
  EXPECT_EQ(place(codestream({8, 9, 0, 0}, 1, 1)), std::nullopt);
}

}  // namespace
}  // namespace octavo::testing
