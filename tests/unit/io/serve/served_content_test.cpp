#include "octavo/io/serve/served_content.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>

#include "octavo/core/error.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;

class ServedFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("octavo-served-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    const std::string path = (folder_ / name).string();
    std::ofstream(path, std::ios::binary) << text;
    return path;
  }

  fs::path folder_;
};

std::string all_of(const ServedBytes& bytes) {
  std::string text(bytes.size(), 0);
  const auto out = std::span(reinterpret_cast<std::uint8_t*>(text.data()), text.size());
  return bytes.read(0, out) ? text : "failed";
}

TEST_F(ServedFile, IsTheOneThatHasTheName) {
  const std::string path = write("a", "first");
  const auto content = file_content(path, "x/y");
  const auto first = content->now();
  EXPECT_EQ(all_of(*first), "first");
  EXPECT_EQ(content->now(), first);
  fs::rename(write("b", "second"), path);
  const auto second = content->now();
  EXPECT_EQ(all_of(*second), "second");
  EXPECT_NE(first->entity_tag(), second->entity_tag());
  // An answer that has begun ends with the file it began with.
  EXPECT_EQ(all_of(*first), "first");
  fs::remove(path);
  EXPECT_EQ(content->now(), nullptr);
  write("a", "third");
  EXPECT_EQ(all_of(*content->now()), "third");
}

TEST_F(ServedFile, FollowsNoLinkThatWasNotThere) {
  const std::string path = write("a", "first");
  const std::string secret = write("secret", "of others");
  const std::string link = (folder_ / "link").string();
  fs::create_symlink("a", link);
  fs::create_directory(folder_ / "sub");
  const std::string below = write("sub/b", "below");
  const auto plain = file_content(path, "");
  const auto linked = file_content(link, "");
  const auto inside = file_content(below, "");
  EXPECT_EQ(all_of(*linked->now()), "first");
  // A link of the start stands for the file that it led to then.
  fs::remove(link);
  fs::create_symlink(secret, link);
  EXPECT_EQ(all_of(*linked->now()), "first");
  fs::remove(path);
  fs::create_symlink(secret, path);
  EXPECT_EQ(plain->now(), nullptr);
  EXPECT_EQ(linked->now(), nullptr);
  fs::rename(folder_ / "sub", folder_ / "moved");
  fs::create_directory(folder_ / "other");
  write("other/b", "of others");
  fs::create_directory_symlink("other", folder_ / "sub");
  EXPECT_EQ(inside->now(), nullptr);
  fs::remove(path);
  write("a", "again");
  EXPECT_EQ(all_of(*plain->now()), "again");
  EXPECT_EQ(all_of(*linked->now()), "again");
}

TEST_F(ServedFile, GivesNothingOfBytesThatWereWrittenTo) {
  const std::string path = write("a", "first");
  const auto bytes = file_content(path, "x/y")->now();
  std::ofstream(path, std::ios::app) << "!";
  std::array<std::uint8_t, 2> part{};
  EXPECT_FALSE(bytes->read(0, part));
}

TEST_F(ServedFile, IsAFileAndNothingElse) {
  EXPECT_THROW(file_content((folder_ / "none").string(), ""), Error);
  EXPECT_THROW(file_content(folder_.string(), ""), Error);
  const std::string pipe = (folder_ / "pipe").string();
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_THROW(file_content(pipe, ""), Error);
}

TEST_F(ServedFile, EndsWhereItEnds) {
  const auto bytes = file_content(write("a", "first"), "")->now();
  std::array<std::uint8_t, 3> part{};
  EXPECT_TRUE(bytes->read(2, part));
  EXPECT_EQ(part[2], 't');
  EXPECT_FALSE(bytes->read(3, part));
  EXPECT_FALSE(bytes->read(99, part));
}

TEST(MemoryContent, HasOneTagForItsBytes) {
  const auto one = memory_content({1, 2, 3}, "a/b")->now();
  const auto other = memory_content({1, 2, 4}, "a/b")->now();
  EXPECT_NE(one->entity_tag(), other->entity_tag());
  std::array<std::uint8_t, 2> part{};
  EXPECT_TRUE(one->read(1, part));
  EXPECT_EQ(part[1], 3);
  EXPECT_FALSE(one->read(2, part));
  EXPECT_FALSE(one->read(UINT64_MAX, part));
}

TEST(MediaType, IsThatOfTheEnding) {
  EXPECT_EQ(media_type_of("octavo.wasm"), "application/wasm");
  EXPECT_EQ(media_type_of("viewer.js"), "text/javascript; charset=utf-8");
  EXPECT_EQ(media_type_of("x"), "application/octet-stream");
}

}  // namespace
}  // namespace octavo
