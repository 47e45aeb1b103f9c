#include "octavo/tasks/affine_file.h"

#include <sys/stat.h>

#include "support/task_files.h"

namespace octavo {
namespace {

class AffineFile : public testing::TaskFiles {
 protected:
  std::string write_text(const std::string& text) {
    std::ofstream(folder_.file("m.txt"), std::ios::binary) << text;
    return folder_.file("m.txt");
  }
};

TEST_F(AffineFile, RowsAreReadInEveryCommonForm) {
  Affine expected;
  expected.linear = {0, -1, 0, 1, 0, 0, 0, 0, 2.5};
  expected.offset = {10, -20, 1e3};
  for (const char* text : {
           "0 -1 0 10\n1 0 0 -20\n0 0 2.5 1e3\n",
           "# turned\n0 -1 0 10\r\n1 0 0 -20 # y\r\n0 0 +2.5 1e3\r\n0 0 0 1",
           "[[0, -1, 0, 10],\n [1, 0, 0, -20],\n [0, 0, 2.5, 1000],\n [0, 0, 0, 1]]",
           "0;-1;0;10;1;0;0;-20;0;0;2.5;1000",
       }) {
    EXPECT_EQ(read_affine(write_text(text)), expected) << text;
  }
}

TEST_F(AffineFile, AnythingElseIsRejected) {
  for (const char* text : {"", "1 2 3", "1 0 0 0 0 1 0 0 0 0 1", "1 0 0 0 0 1 0 0 0 0 one 0",
                           "1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 1", "1 0 0 0 0 1 0 0 1 1 0 0",
                           "1 0 0 nan 0 1 0 0 0 0 1 0", "1 0 0 1e999 0 1 0 0 0 0 1 0"}) {
    EXPECT_EQ(failure_of([&] { read_affine(write_text(text)); }).kind, ErrorKind::source_rejected)
        << text;
  }
  EXPECT_EQ(failure_of([&] { read_affine(write_text(std::string(70000, ' '))); }).kind,
            ErrorKind::source_rejected);
  EXPECT_EQ(failure_of([&] { read_affine(folder_.file("none.txt")); }).kind, ErrorKind::io);
  // Nobody writes into this one.
  ASSERT_EQ(::mkfifo(folder_.file("pipe.txt").c_str(), 0600), 0);
  EXPECT_EQ(failure_of([&] { read_affine(folder_.file("pipe.txt")); }).kind, ErrorKind::io);
}

}  // namespace
}  // namespace octavo
