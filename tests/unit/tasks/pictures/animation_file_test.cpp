#include "octavo/tasks/pictures/animation_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "octavo/core/error.h"
#include "support/built_file.h"
#include "support/read_png.h"

namespace octavo {
namespace {

TEST(AnimationFiles, StandThereWhenTheLastPictureIsInThem) {
  const testing::ScratchFolder folder;
  const std::string path = folder.file("turn.apng");
  EXPECT_TRUE(is_animation(path));
  EXPECT_FALSE(is_animation("turn.png"));
  const TaskContext context;
  AnimationFile file(path, {20, 10, 2, 10}, context);
  Picture picture = make_picture(20, 10, 3);
  file.add(picture);
  picture.set(3, 3, {255, 0, 0});
  file.add(picture);
  EXPECT_FALSE(std::filesystem::exists(path));
  file.publish(false);
  const std::string bytes = testing::bytes_of_file(path);
  EXPECT_EQ(testing::read_png(Bytes(bytes.begin(), bytes.end())).width, 20);
  EXPECT_NE(bytes.find("fdAT"), std::string::npos);
  AnimationFile again(path, {20, 10, 1, 10}, context);
  again.add(picture);
  EXPECT_THROW(again.publish(false), Error);
}

}  // namespace
}  // namespace octavo
