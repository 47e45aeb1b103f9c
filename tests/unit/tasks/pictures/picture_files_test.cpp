#include "octavo/tasks/pictures/picture_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

class PictureFilesTest : public ::testing::Test {
 protected:
  void add(std::initializer_list<const char*> names) {
    for (const char* name : names) files_.add(folder_.file(name), make_picture(4, 4, 1));
  }

  void write(const char* name) { std::ofstream(folder_.file(name)) << "earlier"; }

  bool is_earlier(const char* name) const {
    return testing::bytes_of_file(folder_.file(name)) == "earlier";
  }

  /// What is in the folder.
  std::size_t count() const {
    const auto folder = std::filesystem::path(folder_.file("a")).parent_path();
    const std::filesystem::directory_iterator all(folder);
    return static_cast<std::size_t>(std::distance(begin(all), end(all)));
  }

  testing::ScratchFolder folder_;
  TaskContext context_;
  PictureFiles files_{context_};
};

TEST_F(PictureFilesTest, GetTheirNamesTogether) {
  add({"a.png", "b.png"});
  EXPECT_FALSE(std::filesystem::exists(folder_.file("a.png")));
  files_.publish(false);
  EXPECT_TRUE(std::filesystem::exists(folder_.file("a.png")));
  EXPECT_EQ(count(), 2u);
}

TEST_F(PictureFilesTest, NoneStandsThereWhereOneNameWasTakenMeanwhile) {
  add({"a.png", "b.png", "c.png"});
  write("b.png");
  try {
    files_.publish(false);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::io);
    EXPECT_EQ(error.path(), folder_.file("b.png"));
    EXPECT_EQ(error.field(), "overwrite");
  }
  EXPECT_FALSE(std::filesystem::exists(folder_.file("a.png")));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("c.png")));
  EXPECT_TRUE(is_earlier("b.png"));
}

TEST_F(PictureFilesTest, WhatReplacedAnEarlierOneStays) {
  add({"a.png", "b.png", "c.png"});
  write("a.png");
  std::filesystem::create_directory(folder_.file("c.png"));
  EXPECT_THROW(files_.publish(true), Error);
  EXPECT_FALSE(is_earlier("a.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_.file("b.png")));
}

}  // namespace
}  // namespace octavo
