// The small parts that readers and writers are made of.
#include <gtest/gtest.h>

#include <numeric>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/storage/temporary.h"
#include "octavo/file/write/append_file.h"
#include "octavo/file/write/spool.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using octavo::testing::MemoryStorage;

Bytes numbered(std::size_t count, std::uint8_t first) {
  Bytes bytes(count);
  std::iota(bytes.begin(), bytes.end(), first);
  return bytes;
}

TEST(LruCache, WhatWasNotUsedForTheLongestTimeGoesFirst) {
  LruCache<int> cache(10);
  const auto value = std::make_shared<const int>(7);
  cache.insert({0, 1}, value, 4);
  cache.insert({0, 2}, value, 4);
  EXPECT_NE(cache.find({0, 1}), nullptr);
  cache.insert({0, 3}, value, 4);
  EXPECT_EQ(cache.find({0, 2}), nullptr);
  EXPECT_NE(cache.find({0, 1}), nullptr);
  EXPECT_NE(cache.find({0, 3}), nullptr);
  // A heavy one takes the room of both; what was handed out lives on.
  const auto kept = cache.find({0, 1});
  cache.insert({0, 4}, value, 10);
  EXPECT_EQ(cache.find({0, 1}), nullptr);
  EXPECT_EQ(cache.find({0, 3}), nullptr);
  EXPECT_EQ(*kept, 7);
}

TEST(LruCache, KeepsTheFirstOfAKeyAndNothingThatIsTooHeavy) {
  LruCache<int> cache(10);
  cache.insert({1, 1}, std::make_shared<const int>(1), 10);
  cache.insert({1, 1}, std::make_shared<const int>(2), 1);
  EXPECT_EQ(*cache.find({1, 1}), 1);
  cache.insert({2, 1}, std::make_shared<const int>(3), 11);
  EXPECT_EQ(cache.find({2, 1}), nullptr);
  EXPECT_NE(cache.find({1, 1}), nullptr);
}

TEST(AppendFile, PiecesOfAnySizeStandOneAfterAnother) {
  MemoryStorage storage;
  AppendFile file(storage.create_exclusive("a"));
  Bytes all;
  for (const std::size_t count : {100u, 1u << 20, (1u << 20) + 1, 0u, 7u, 3u << 20, 1u}) {
    const Bytes piece = numbered(count, static_cast<std::uint8_t>(count + 3));
    const Section section = file.append_section(piece);
    EXPECT_EQ(section.offset, kHeaderBytes + all.size());
    EXPECT_EQ(section.length, count);
    EXPECT_EQ(section.crc, crc32c(piece));
    all.insert(all.end(), piece.begin(), piece.end());
    EXPECT_EQ(file.size(), kHeaderBytes + all.size());
  }
  file.flush();
  const std::size_t calls = storage.calls.size();
  file.flush();
  EXPECT_EQ(storage.calls.size(), calls);
  EXPECT_EQ(file.digest(), crc32c(all));
  const auto& written = *storage.files.at("a");
  EXPECT_TRUE(std::equal(all.begin(), all.end(), written.begin() + kHeaderBytes, written.end()));
}

TEST(Spool, GivesEveryStreamBackInOrder) {
  MemoryStorage storage;
  Spool spool(storage, ".", 3);
  Bytes expected[3];
  for (int turn = 0; turn < 40; ++turn) {
    for (std::size_t stream = 0; stream < 2; ++stream) {
      const Bytes piece = numbered(20'000 + 777 * stream, static_cast<std::uint8_t>(turn));
      spool.append(stream, piece);
      expected[stream].insert(expected[stream].end(), piece.begin(), piece.end());
    }
  }
  spool.flush();
  for (std::size_t stream = 0; stream < 3; ++stream) {
    Bytes found;
    spool.copy(stream, [&](ByteSpan bytes) {
      found.insert(found.end(), bytes.begin(), bytes.end());
    });
    EXPECT_TRUE(found == expected[stream]) << stream;
    EXPECT_EQ(spool.size(stream), expected[stream].size());
  }
}

TEST(MemorySource, EndsWhereItsBytesEnd) {
  const auto source = byte_source_of({1, 2, 3}, "bytes");
  Bytes out(2);
  source->read(1, out);
  EXPECT_EQ(out, (Bytes{2, 3}));
  for (const std::uint64_t offset : {std::uint64_t{2}, std::uint64_t{4}, ~std::uint64_t{0}}) {
    try {
      source->read(offset, out);
      ADD_FAILURE() << offset;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::truncated);
      EXPECT_EQ(error.path(), "bytes");
    }
  }
}

TEST(Storage, WithoutFoldersSaysSo) {
  MemoryStorage storage;
  EXPECT_FALSE(storage.exchange("a", "b"));
  EXPECT_THROW(create_temporary_folder(storage, "a"), Error);
  EXPECT_EQ(storage.path_type("a"), PathType::missing);
  storage.create_exclusive("a");
  EXPECT_EQ(storage.path_type("a"), PathType::file);
}

TEST(Paths, HaveAFolderAndAName) {
  EXPECT_EQ(folder_of("a"), ".");
  EXPECT_EQ(folder_of("/a"), "/");
  EXPECT_EQ(folder_of("b/c/a"), "b/c");
  EXPECT_EQ(base_name_of("b/c/a"), "a");
  EXPECT_EQ(base_name_of("a"), "a");
}

}  // namespace
}  // namespace octavo
