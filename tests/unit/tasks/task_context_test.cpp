#include "octavo/tasks/task_context.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"

namespace octavo {
namespace {

TEST(TaskContext, VolumesOfMoreVoxelsThanTheLimitAreRejectedWithBothNumbers) {
  TaskContext context;
  const Size3 largest = {std::int64_t{1} << 14, std::int64_t{1} << 14, std::int64_t{1} << 12};
  const Size3 larger = {largest.x, largest.y, largest.z + 1};
  EXPECT_NO_THROW(context.require_voxels(largest, "a.8vo"));
  try {
    context.require_voxels(larger, "a.8vo");
    ADD_FAILURE() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    EXPECT_EQ(error.path(), "a.8vo");
    EXPECT_EQ(error.field(), "max_voxels");
    EXPECT_EQ(error.detail(),
              "a volume of 16384 x 16384 x 4097 voxels; the limit is 1099511627776");
  }
  context.max_voxels = 0;
  EXPECT_NO_THROW(context.require_voxels(larger, "a.8vo"));
}

}  // namespace
}  // namespace octavo
