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

TEST_F(LabelFile, OneFileOfAllPartsTakesMoreMemoryThanOneByOne) {
  const auto fits = [&](const std::string& output, std::uint64_t bytes) {
    context_.max_memory_bytes = bytes;
    options_.output = {folder_.file(output), true};
    try {
      return label_surfaces(options_, context_).is_written;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
      return false;
    }
  };
  std::uint64_t bytes = 100'000;
  while (!fits("parts", bytes)) bytes += bytes / 8;
  EXPECT_FALSE(fits("parts.glb", bytes));
  EXPECT_TRUE(fits("parts.glb", 8 * bytes));
}

/// Proves that what is asked for fails before any progress is reported.
void expect_early(const LabelSurfacesOptions& options, TaskContext context, ErrorKind kind) {
  testing::StoppingProgress progress(1 << 30);
  context.progress = &progress;
  try {
    label_surfaces(options, context);
    ADD_FAILURE() << options.output.path;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), kind) << error.what();
  }
  EXPECT_EQ(progress.total_, 0) << options.output.path;
}

TEST_F(LabelFile, SaysBeforeTheWorkWhatCannotBeWritten) {
  for (const char* const output : {"missing/parts", "missing/parts.ply"}) {
    options_.output.path = folder_.file(output);
    expect_early(options_, context_, ErrorKind::io);
  }
  options_.output.path = labels_.path() + "/parts";
  expect_early(options_, context_, ErrorKind::io);

  std::filesystem::create_directories(folder_.file("parts"));
  options_.output.path = folder_.file("parts");
  options_.labels.numbers = {3};
  EXPECT_TRUE(label_surfaces(options_, context_).is_written);
  expect_early(options_, context_, ErrorKind::io);
}

TEST_F(LabelFile, SaysBeforeTheWorkThatPlyHasNoSuchLabel) {
  const testing::BuiltLabels large({4, 4, 4}, std::vector<std::uint32_t>(64, 4'000'000'000u));
  options_.input = large.path();
  options_.output.path = folder_.file("large.ply");
  expect_early(options_, context_, ErrorKind::limit_exceeded);
  options_.output.path = folder_.file("large");
  EXPECT_TRUE(label_surfaces(options_, context_).is_written);
  options_.output.path = folder_.file("plain");
  options_.part_format = MeshFormat::ply;
  expect_early(options_, context_, ErrorKind::limit_exceeded);
}

}  // namespace
}  // namespace octavo
