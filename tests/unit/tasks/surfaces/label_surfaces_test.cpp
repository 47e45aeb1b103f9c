#include "octavo/tasks/surfaces/label_surfaces.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "octavo/core/error.h"
#include "support/built_labels.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

class LabelFile : public ::testing::Test {
 protected:
  void SetUp() override { options_.input = labels_.path(); }

  testing::BuiltLabels labels_{{12, 11, 10}, testing::random_labels({12, 11, 10}, 5, 4, 3)};
  testing::ScratchFolder folder_;
  LabelSurfacesOptions options_;
  TaskContext context_;
};

TEST_F(LabelFile, GivesTheSameBytesWithAnyThreads) {
  const auto bytes_with = [&](int threads) {
    context_.threads = threads;
    options_.output = {folder_.file("parts.ply"), true};
    EXPECT_TRUE(label_surfaces(options_, context_).is_written);
    return testing::bytes_of_file(options_.output.path);
  };
  const std::string one = bytes_with(1);
  EXPECT_FALSE(one.empty());
  EXPECT_EQ(bytes_with(3), one);
}

TEST_F(LabelFile, LeavesNothingWhenStopped) {
  options_.output.path = folder_.file("parts");
  testing::StoppingProgress stopping;
  context_.progress = &stopping;
  EXPECT_THROW(label_surfaces(options_, context_), Error);
  EXPECT_TRUE(folder_.is_empty());
}

TEST_F(LabelFile, WritesAllPartsOrNone) {
  options_.output.path = folder_.file("parts");
  std::filesystem::create_directories(folder_.file("parts/label_3.stl"));
  EXPECT_THROW(label_surfaces(options_, context_), Error);
  std::size_t count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder_.file("parts"))) {
    count += entry.exists() ? 1u : 0u;
  }
  EXPECT_EQ(count, 1u);
}

TEST_F(LabelFile, KeepsWithinTheMemoryLimit) {
  options_.output.path = folder_.file("parts");
  context_.max_memory_bytes = 100'000;
  try {
    label_surfaces(options_, context_);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
  EXPECT_TRUE(folder_.is_empty());
}

}  // namespace
}  // namespace octavo
