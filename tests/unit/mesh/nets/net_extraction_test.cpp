#include "octavo/mesh/nets/net_extraction.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <set>

#include "octavo/core/error.h"
#include "support/built_labels.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

SurfaceNet net_of(const FileReader& reader, int level = 0, int threads = 1) {
  NetCollector collector;
  NoProgress progress;
  tbb::task_arena(threads).execute([&] { extract_net(reader, level, collector, progress); });
  return collector.take();
}

/// The label of a voxel, 0 outside.
template <class T>
std::int64_t label_at(const Size3& size, const std::vector<T>& voxels, const Index3& p) {
  if (!box_of(size).contains(p)) return 0;
  return voxels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
}

TEST(NetExtraction, HasAQuadForEachFaceBetweenLabels) {
  for (const auto& [size, grain] :
       {std::pair{Size3{8, 7, 6}, std::int64_t{1}}, std::pair{Size3{66, 5, 65}, std::int64_t{3}},
        std::pair{Size3{64, 64, 3}, std::int64_t{9}}, std::pair{Size3{1, 1, 1}, std::int64_t{1}}}) {
    std::vector<std::int16_t> voxels = testing::random_labels(size, 3, 5, grain);
    voxels[0] = 9;
    const testing::BuiltLabels labels(size, voxels);
    const SurfaceNet net = net_of(labels.reader());
    // Lower corner of the face, axis, label inside, label outside.
    std::set<std::array<std::int64_t, 6>> expected;
    for (std::int64_t z = 0; z <= size.z; ++z) {
      for (std::int64_t y = 0; y <= size.y; ++y) {
        for (std::int64_t x = 0; x <= size.x; ++x) {
          const std::int64_t own = label_at(size, voxels, {x, y, z});
          for (std::int64_t axis = 0; axis < 3; ++axis) {
            const std::int64_t other =
                label_at(size, voxels, {x - (axis == 0), y - (axis == 1), z - (axis == 2)});
            if (own == other) continue;
            expected.insert({x, y, z, axis, std::max(own, other), std::min(own, other)});
          }
        }
      }
    }
    std::set<std::array<std::int64_t, 6>> found;
    for (const NetQuad& quad : net.quads) {
      NetPoint low = net.points[quad.corners[0]];
      NetPoint high = low;
      for (const std::uint32_t corner : quad.corners) {
        for (std::size_t axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], net.points[corner][axis]);
          high[axis] = std::max(high[axis], net.points[corner][axis]);
        }
      }
      std::int64_t across = 0;
      while (low[static_cast<std::size_t>(across)] != high[static_cast<std::size_t>(across)]) {
        ++across;
      }
      const auto& [inside, outside] = net.pairs[quad.pair];
      found.insert({low[0], low[1], low[2], across, inside, outside});
    }
    EXPECT_EQ(found, expected);
    EXPECT_EQ(net.quads.size(), expected.size());
    // No corner twice.
    EXPECT_EQ(std::set<NetPoint>(net.points.begin(), net.points.end()).size(), net.points.size());
  }
}

TEST(NetExtraction, DoesNotDependOnThreadsOrBricks) {
  const Size3 size = {130, 70, 66};
  const auto voxels = testing::random_labels(size, 1, 4, 5);
  Geometry flat;
  flat.spacing_mm[2] = 4;  // makes bricks flat
  const testing::BuiltLabels even(size, voxels);
  const testing::BuiltLabels uneven(size, voxels, flat);
  ASSERT_NE(even.reader().levels().brick_side(0), uneven.reader().levels().brick_side(0));
  const SurfaceNet net = net_of(even.reader());
  EXPECT_EQ(net_of(even.reader(), 0, 2), net);
  EXPECT_EQ(net_of(even.reader(), 0, 7), net);
  EXPECT_EQ(net_of(uneven.reader()), net);
}

TEST(NetExtraction, TakesLabelsOfAllWidths) {
  const Size3 size = {3, 1, 1};
  const auto pair_of = [&](const auto& voxels) {
    return net_of(testing::BuiltLabels(size, voxels).reader()).pairs;
  };
  EXPECT_EQ(pair_of(std::vector<std::uint8_t>{255, 255, 255}),
            (std::vector<LabelPair>{{255, 0}}));
  // 0 lies outside, also of negative labels.
  EXPECT_EQ(pair_of(std::vector<std::int8_t>{-3, -3, -3}), (std::vector<LabelPair>{{-3, 0}}));
  EXPECT_EQ(pair_of(std::vector<std::uint32_t>{4'000'000'000, 0, 7}),
            (std::vector<LabelPair>{{4'000'000'000, 0}, {7, 0}}));
}

TEST(NetExtraction, KeepsNoMoreThanTheLimitAndStops) {
  const Size3 size = {40, 40, 40};
  const testing::BuiltLabels labels(size, testing::random_labels(size, 2, 5));
  NetCollector collector(10'000);
  NoProgress progress;
  try {
    extract_net(labels.reader(), 0, collector, progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
  testing::StoppingProgress stopping;
  NetCollector all;
  EXPECT_THROW(extract_net(labels.reader(), 0, all, stopping), Error);
  EXPECT_THROW(extract_net(labels.reader(), 99, all, progress), Error);
}

}  // namespace
}  // namespace octavo
