#include "octavo/tasks/pictures/ray_memory.h"

#include <gtest/gtest.h>

#include <cstdio>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

TEST(RayMemory, ThatOfNoBrickIsRejectedWithTheLimitThatWouldDo) {
  const testing::ScratchFolder folder;
  testing::Volume volume;
  volume.description.size = {40, 40, 40};
  volume.description.type = VoxelType::uint8;
  for (std::int64_t i = 0; i < 40 * 40 * 40; ++i) {
    volume.voxels.push_back(static_cast<std::byte>(i % 251));
  }
  testing::build_volume(volume, folder.file("v.8vo"), 1);
  RenderOptions options;
  options.input = folder.file("v.8vo");
  options.output = {folder.file("v.png"), true};
  options.mode = RenderMode::mip;
  options.width = options.height = 50;
  for (const int threads : {1, 2}) {
    TaskContext context;
    context.threads = threads;
    context.max_memory_bytes = 2 << 20;
    try {
      render(options, context);
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
      const std::string text = error.what();
      unsigned long named = 0;
      ASSERT_EQ(std::sscanf(text.c_str(), "drawing with rays would take about %lu MiB", &named), 1)
          << text;
      EXPECT_EQ(text.find("fewer threads") != std::string::npos, threads > 1) << text;
      context.max_memory_bytes = (named - 1) << 20;
      EXPECT_THROW(render(options, context), Error);
      context.max_memory_bytes = named << 20;
      EXPECT_NO_THROW(render(options, context));
    }
  }
}

}  // namespace
}  // namespace octavo
