#include "octavo/file/storage/sparse_source.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <random>

#include "octavo/core/error.h"

namespace octavo {
namespace {

using FileContent = std::vector<std::uint8_t>;

FileContent content_of(std::size_t size) {
  FileContent content(size);
  for (std::size_t i = 0; i < size; ++i) content[i] = static_cast<std::uint8_t>(i * 37 >> 3);
  return content;
}

std::span<const std::uint8_t> part_of(const FileContent& content, const ByteRange& range) {
  return std::span(content).subspan(range.offset, range.length);
}

std::optional<ErrorKind> failure_of_read(const ByteSource& source, const ByteRange& range) {
  FileContent out(range.length);
  try {
    source.read(range.offset, out);
  } catch (const Error& error) {
    EXPECT_EQ(error.path(), source.name());
    return error.kind();
  }
  return std::nullopt;
}

/// Against a flag for each byte.
TEST(SparseSource, ReadsThoseBytesThatWerePutAndNamesTheOthers) {
  constexpr std::uint64_t kSize = 200;
  const FileContent content = content_of(kSize);
  std::mt19937 random(5);
  const auto any_range = [&] {
    const std::uint64_t offset = random() % (kSize + 1);
    return ByteRange{offset, random() % std::min<std::uint64_t>(kSize - offset + 1, 40)};
  };
  for (int round = 0; round < 60; ++round) {
    SparseSource source(kSize, "sparse");
    std::vector<bool> is_there(kSize);
    for (int i = 0; i < 12; ++i) {
      const ByteRange put = any_range();
      source.put(put.offset, part_of(content, put));
      for (std::uint64_t at = put.offset; at < put.end(); ++at) is_there[at] = true;
      ASSERT_EQ(source.byte_count(),
                static_cast<std::uint64_t>(std::count(is_there.begin(), is_there.end(), true)));

      const std::vector<ByteRange> asked{any_range(), any_range(), any_range()};
      std::vector<bool> is_missing(kSize);
      for (const ByteRange& range : asked) {
        bool is_whole = true;
        for (std::uint64_t at = range.offset; at < range.end(); ++at) {
          is_whole = is_whole && is_there[at];
          if (!is_there[at]) is_missing[at] = true;
        }
        const auto failure = failure_of_read(source, range);
        ASSERT_EQ(failure, is_whole ? std::nullopt : std::optional(ErrorKind::io));
        if (!is_whole) continue;
        FileContent out(range.length);
        source.read(range.offset, out);
        ASSERT_TRUE(std::equal(out.begin(), out.end(), part_of(content, range).begin()));
      }
      std::vector<bool> found(kSize);
      for (const ByteRange& range : source.missing(asked)) {
        for (std::uint64_t at = range.offset; at < range.end(); ++at) found[at] = true;
      }
      ASSERT_EQ(found, is_missing);
    }
  }
}

TEST(SparseSource, BytesBeyondTheEndAreRejected) {
  const FileContent content = content_of(20);
  SparseSource source(20, "sparse");
  EXPECT_THROW(source.put(1, content), Error);
  EXPECT_THROW(source.put(~std::uint64_t{0}, part_of(content, {0, 2})), Error);
  EXPECT_EQ(source.byte_count(), 0u);
  source.put(0, content);
  source.put(20, {});
  EXPECT_EQ(failure_of_read(source, {19, 2}), ErrorKind::truncated);
  EXPECT_EQ(failure_of_read(source, {~std::uint64_t{0}, 2}), ErrorKind::truncated);
  EXPECT_EQ(failure_of_read(source, {20, 0}), std::nullopt);
}

TEST(SparseBytes, WhatIsDroppedIsMissingWithTheRunsAroundIt) {
  const FileContent content = content_of(100);
  SparseBytes bytes;
  for (const std::uint64_t at : {0u, 20u, 60u}) bytes.put(at, part_of(content, {at, 20}));
  const ByteRange held{25, 1};
  const auto hold = bytes.hold({&held, 1});
  const std::vector<ByteRange> dropped = {{30, 5}, {45, 10}};
  bytes.drop(dropped);
  const ByteRange all{0, 100};
  EXPECT_EQ(bytes.missing({&all, 1}), (std::vector<ByteRange>{{20, 40}, {80, 20}}));
  EXPECT_EQ(bytes.byte_count(), 40u);
  bytes.put(20, part_of(content, {20, 20}));
  bytes.shrink_to(0);
  EXPECT_EQ(bytes.byte_count(), 20u);
}

TEST(SparseSource, WhatWasPutFirstGoesFirst) {
  const FileContent content = content_of(100);
  SparseSource source(100, "sparse");
  for (const std::uint64_t at : {40u, 0u, 80u}) source.put(at, part_of(content, {at, 20}));
  source.put(30, part_of(content, {30, 20}));  // of these, 10 are new
  source.shrink_to(70);
  EXPECT_EQ(source.byte_count(), 70u);
  source.shrink_to(69);
  EXPECT_EQ(source.byte_count(), 50u);
  const ByteRange all{0, 100};
  EXPECT_EQ(source.missing({&all, 1}), (std::vector<ByteRange>{{20, 10}, {40, 40}}));
  source.shrink_to(0);
  EXPECT_EQ(source.missing({&all, 1}), (std::vector<ByteRange>{{0, 100}}));
}

TEST(SparseSource, WhatIsHeldStaysWhetherItWasPutBeforeOrAfter) {
  const FileContent content = content_of(100);
  SparseSource source(100, "sparse");
  const ByteRange all{0, 100};
  for (const std::uint64_t at : {0u, 20u, 40u}) source.put(at, part_of(content, {at, 20}));
  auto early = source.hold(std::vector<ByteRange>{{65, 10}, {19, 1}, {60, 5}});
  auto twice = source.hold(std::vector<ByteRange>{{10, 5}});
  for (const std::uint64_t at : {60u, 80u}) source.put(at, part_of(content, {at, 20}));
  source.shrink_to(60);
  EXPECT_EQ(source.missing({&all, 1}), (std::vector<ByteRange>{{20, 40}}));
  source.shrink_to(0);
  EXPECT_EQ(source.missing({&all, 1}), (std::vector<ByteRange>{{20, 40}, {80, 20}}));
  early.reset();
  source.shrink_to(0);
  EXPECT_EQ(source.missing({&all, 1}), (std::vector<ByteRange>{{20, 80}}));
  twice.reset();
  source.shrink_to(0);
  EXPECT_EQ(source.byte_count(), 0u);
}

}  // namespace
}  // namespace octavo
