#include "octavo/file/directory.h"

#include <gtest/gtest.h>

#include <functional>

#include "octavo/core/error.h"

namespace octavo {
namespace {

constexpr PartTag kNotes = {'n', 'o', 't', 'e'};

// Pages end at 1000; a part of 10 bytes and one of 20 reach the directory.
FileHeader header_with_parts() {
  FileHeader header;
  header.pages = {900, 100, 0};
  header.directory = {1030, 2 * kPartEntryBytes, 0};
  return header;
}

std::vector<PartEntry> two_parts() {
  return {{kNotes, kRestPart, {1000, 10, 7}}, {kThumbnailTag, kThumbnailFlags, {1010, 20, 8}}};
}

TEST(Directory, ParsesBackToWhatWasEncoded) {
  const Bytes bytes = encode_directory(two_parts());
  const auto parts = parse_directory(bytes, header_with_parts());
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_EQ(parts[0].tag, kNotes);
  EXPECT_EQ(parts[0].flags, kRestPart);
  EXPECT_EQ(parts[1].bytes.offset, 1010u);
  EXPECT_EQ(parts[1].bytes.length, 20u);
  EXPECT_EQ(parts[1].bytes.crc, 8u);
  EXPECT_EQ(encode_directory(parts), bytes);
  FileHeader empty = header_with_parts();
  empty.directory = {1000, 0, 0};
  EXPECT_TRUE(parse_directory({}, empty).empty());
}

TEST(Directory, WhatItCannotHoldIsDamageAndWhatIsUnknownIsNewer) {
  const struct {
    const char* what;
    ErrorKind kind;
    std::function<void(std::vector<PartEntry>&, FileHeader&)> change;
  } cases[] = {
      {"a gap", ErrorKind::corrupt, [](auto& p, auto&) { ++p[1].bytes.offset; }},
      {"an overlap", ErrorKind::corrupt, [](auto& p, auto&) { --p[1].bytes.offset; }},
      {"beyond the directory", ErrorKind::corrupt, [](auto& p, auto&) { ++p[1].bytes.length; }},
      {"an endless part", ErrorKind::corrupt,
       [](auto& p, auto&) { p[0].bytes.length = ~std::uint64_t{0}; }},
      {"before the directory", ErrorKind::corrupt, [](auto&, auto& h) { ++h.directory.offset; }},
      {"a tag that is no word", ErrorKind::corrupt, [](auto& p, auto&) { p[0].tag[2] = ' '; }},
      {"two thumbnails", ErrorKind::corrupt,
       [](auto& p, auto&) { p[0] = {kThumbnailTag, kThumbnailFlags, p[0].bytes}; }},
      {"a thumbnail with other flags", ErrorKind::corrupt,
       [](auto& p, auto&) { p[1].flags |= kRestPart; }},
      {"a large thumbnail", ErrorKind::corrupt,
       [](auto& p, auto& h) {
         p[1].bytes.length = kMaxThumbnailBytes + 1;
         h.directory.offset = p[1].bytes.end();
       }},
      {"a required part", ErrorKind::unsupported_version,
       [](auto& p, auto&) { p[0].flags = kRequiredPart; }},
      {"a flag", ErrorKind::unsupported_version, [](auto& p, auto&) { p[0].flags = 8; }},
      {"a required part behind a gap", ErrorKind::unsupported_version,
       [](auto& p, auto&) {
         ++p[0].bytes.offset;
         p[1].tag = kNotes;
         p[1].flags = kRequiredPart;
       }},
      {"a high flag", ErrorKind::unsupported_version,
       [](auto& p, auto&) { p[1].flags = 0x80000000u; }},
  };
  for (const auto& c : cases) {
    auto parts = two_parts();
    FileHeader header = header_with_parts();
    c.change(parts, header);
    try {
      parse_directory(encode_directory(parts), header);
      ADD_FAILURE() << c.what;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), c.kind) << c.what << ": " << error.detail();
    }
  }
  Bytes newer = encode_directory(two_parts());
  newer.back() = 1;
  try {
    parse_directory(newer, header_with_parts());
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::unsupported_version);
  }
  const Bytes whole = encode_directory(two_parts());
  for (std::size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THROW(parse_directory(ByteSpan(whole).first(length), header_with_parts()), Error);
  }
}

}  // namespace
}  // namespace octavo
