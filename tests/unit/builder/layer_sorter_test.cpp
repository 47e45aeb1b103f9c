#include "octavo/builder/layer_sorter.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "octavo/file/layer_order.h"
#include "support/memory_storage.h"
#include "support/stopping_progress.h"

namespace octavo::testing {
namespace {

/// Keeps what comes, and how many bricks came before the digests and the end of the group.
class KeptBricks final : public BrickSink {
 public:
  void add_model(const Bytes&) override {}
  void add_brick(int, const EncodedBrick& brick) override { bricks.push_back(brick); }
  void add_plane_digests(std::span<const Sha256Digest>) override { digests_at = bricks.size(); }
  void end_group(std::uint32_t) override { group_at = bricks.size(); }

  std::vector<EncodedBrick> bricks;
  std::size_t digests_at = 0;
  std::size_t group_at = 0;
};

class LayerSorting : public ::testing::Test {
 protected:
  /// The bricks of a layer, row by row; of brick i the second segment has i bytes.
  void add_layer(LayerSorter& sorter) const {
    for (std::int64_t i = 0; i < grid_.x * grid_.y; ++i) {
      EncodedBrick brick;
      brick.parent = i;
      brick.segments = {Bytes(3, 7), Bytes(static_cast<std::size_t>(i), 9), {}};
      sorter.add_brick(0, brick);
    }
  }

  Levels levels_{Size3{140, 200, 130}, choose_halvings(Size3{140, 200, 130}, {1, 1, 1})};
  Size3 grid_ = levels_.brick_grid(0);
  MemoryStorage storage_;
  KeptBricks kept_;
};

TEST_F(LayerSorting, BricksComeInFileOrderWithTheirSegments) {
  const StoppingProgress progress(1000);
  LayerSorter sorter(levels_, kept_, storage_, "", progress);
  const std::vector<Index3> order = layer_order(grid_);
  for (std::size_t layer = 1; layer <= 2; ++layer) {
    add_layer(sorter);
    if (layer == 2) sorter.end_group(1);
    EXPECT_EQ(kept_.bricks.size(), (layer - 1) * order.size());
    sorter.end_layer({});
    ASSERT_EQ(kept_.bricks.size(), layer * order.size());
    EXPECT_EQ(kept_.digests_at, kept_.bricks.size() - 1);
  }
  EXPECT_EQ(kept_.group_at, kept_.bricks.size());
  for (std::size_t i = 0; i < kept_.bricks.size(); ++i) {
    const Index3& at = order[i % order.size()];
    const EncodedBrick& brick = kept_.bricks[i];
    EXPECT_EQ(brick.parent, at.y * grid_.x + at.x);
    ASSERT_EQ(brick.segments.size(), 3u);
    EXPECT_EQ(brick.segments[0], Bytes(3, 7));
    EXPECT_EQ(brick.segments[1], Bytes(static_cast<std::size_t>(brick.parent), 9));
    EXPECT_TRUE(brick.segments[2].empty());
  }
}

TEST_F(LayerSorting, StopsBetweenBricks) {
  const StoppingProgress progress(5);
  LayerSorter sorter(levels_, kept_, storage_, "", progress);
  add_layer(sorter);
  try {
    sorter.end_layer({});
    ADD_FAILURE() << "nothing stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::cancelled) << error.what();
  }
  EXPECT_EQ(kept_.bricks.size(), 5u);
}

}  // namespace
}  // namespace octavo::testing
