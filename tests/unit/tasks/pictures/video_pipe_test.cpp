#include "octavo/tasks/pictures/video_pipe.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;

/// A program called ffmpeg that alone is found.
class PretendedFfmpeg : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* const path = std::getenv("PATH");
    path_ = path != nullptr ? path : "";
  }
  void TearDown() override { ::setenv("PATH", path_.c_str(), 1); }

  void pretend(const std::string& does) {
    fs::create_directories(folder_.file("bin"));
    std::ofstream(folder_.file("bin/ffmpeg")) << "#!/bin/sh\n" << does << '\n';
    fs::permissions(folder_.file("bin/ffmpeg"), fs::perms::owner_all);
    ::setenv("PATH", (folder_.file("bin") + ":/bin:/usr/bin").c_str(), 1);
  }

  testing::ScratchFolder folder_;
  std::string path_;
};

TEST_F(PretendedFfmpeg, GetsThePixelsOfAllPictures) {
  // The last word is the file.
  pretend("for last; do :; done; cat > \"$last\"");
  const std::string path = folder_.file("turn.mp4");
  VideoPipe video(path, 9, 7, 10);
  Picture picture = make_picture(9, 7, 3);
  picture.set(2, 1, {10, 20, 30});
  video.add(picture);
  video.add(picture);
  video.finish();
  const std::string bytes = testing::bytes_of_file(path);
  const std::string one(picture.pixels.begin(), picture.pixels.end());
  EXPECT_EQ(bytes, one + one);
  EXPECT_THROW(VideoPipe(path, 9, 7, 10).add(make_picture(4, 4, 3)), Error);
}

TEST_F(PretendedFfmpeg, ItsFailuresAreErrors) {
  const std::string path = folder_.file("turn.mp4");
  pretend("cat > /dev/null; exit 3");
  VideoPipe failing(path, 9, 7, 10);
  failing.add(make_picture(9, 7, 3));
  EXPECT_THROW(failing.finish(), Error);
  pretend("exit 3");
  VideoPipe ended(path, 900, 700, 10);
  EXPECT_THROW(
      {
        for (int i = 0; i < 50; ++i) ended.add(make_picture(900, 700, 3));
      },
      Error);
  fs::create_directories(folder_.file("empty"));
  ::setenv("PATH", folder_.file("empty").c_str(), 1);
  try {
    VideoPipe(path, 9, 7, 10);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.field(), "animation.ffmpeg");
    EXPECT_NE(std::string(error.what()).find("ffmpeg"), std::string::npos);
  }
}

TEST(VideoPipe, OddSizesBecomeAVideo) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) {
    GTEST_SKIP() << "this machine has no ffmpeg";
  }
  const testing::ScratchFolder folder;
  const std::string path = folder.file("turn.mp4");
  VideoPipe video(path, 33, 21, 10);
  for (int i = 0; i < 4; ++i) video.add(make_picture(33, 21, 3));
  video.finish();
  EXPECT_EQ(testing::bytes_of_file(path).substr(4, 4), "ftyp");
}

}  // namespace
}  // namespace octavo
