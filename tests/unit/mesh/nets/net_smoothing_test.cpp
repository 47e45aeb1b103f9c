#include "octavo/mesh/nets/net_smoothing.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>

#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/interface_mesh.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "support/built_labels.h"

namespace octavo {
namespace {

/// A ball of two halves, labels 1 and 2.
class HalvedBall : public ::testing::Test {
 protected:
  static constexpr double kRadius = 12.3;
  static constexpr double kMiddle = 15;

  void SetUp() override {
    std::vector<std::int16_t> voxels;
    for (int z = 0; z < 31; ++z) {
      for (int y = 0; y < 31; ++y) {
        for (int x = 0; x < 31; ++x) {
          const double from = std::hypot(x - kMiddle, y - kMiddle, z - kMiddle);
          const double along = 0.5 * (x - kMiddle) + 0.3 * (y - kMiddle) + (z - kMiddle);
          const int label = from > kRadius ? 0 : along > 0.1 ? 2 : 1;
          voxels.push_back(static_cast<std::int16_t>(label));
        }
      }
    }
    const testing::BuiltLabels labels({31, 31, 31}, voxels);
    NetCollector collector;
    NoProgress progress;
    extract_net(labels.reader(), 0, collector, progress);
    net_ = collector.take();
  }

  TriangleMesh part(int steps, std::int64_t label) const {
    const SurfaceFrame frame({}, {31, 31, 31});
    const InterfaceMesh made = interface_mesh(net_, smoothed_offsets(net_, steps), frame);
    return LabelParts(made).cut(label);
  }

  SurfaceNet net_;
};

TEST_F(HalvedBall, KeepsItsVolumeAndStaysInItsCells) {
  for (const int steps : {1, 10, 40}) {
    double longest = 0;
    for (const NetOffset& offset : smoothed_offsets(net_, steps)) {
      for (const float value : offset) {
        longest = std::max(longest, std::abs(static_cast<double>(value)));
      }
    }
    EXPECT_LT(longest, 0.5);
    EXPECT_GT(longest, 0.1);
    for (const std::int64_t label : {1, 2}) {
      const double before = measure_mesh(part(0, label)).volume_mm3;
      EXPECT_NEAR(measure_mesh(part(steps, label)).volume_mm3 / before, 1, 0.01);
    }
  }
}

TEST_F(HalvedBall, GetsSmoother) {
  // How far points of the outer surface lie from the ball.
  const auto error = [&](int steps) {
    const TriangleMesh mesh = part(steps, 1);
    double sum = 0;
    double count = 0;
    for (const MeshPoint& point : mesh.points) {
      const double from = std::hypot(static_cast<double>(point[0]) - kMiddle,
                                     static_cast<double>(point[1]) - kMiddle,
                                     static_cast<double>(point[2]) - kMiddle);
      if (from < kRadius - 1.5) continue;
      sum += (from - kRadius) * (from - kRadius);
      ++count;
    }
    return std::sqrt(sum / count);
  };
  EXPECT_LT(error(5), 0.8 * error(0));
  EXPECT_LT(error(20), 0.6 * error(0));
  // The area of steps is that of the sides of their cubes.
  EXPECT_LT(measure_mesh(part(20, 1)).area_mm2, 0.75 * measure_mesh(part(0, 1)).area_mm2);
}

TEST_F(HalvedBall, DoesNotDependOnThreads) {
  const std::vector<NetOffset> offsets = smoothed_offsets(net_, 7);
  for (const int threads : {1, 3}) {
    tbb::task_arena(threads).execute([&] { EXPECT_EQ(smoothed_offsets(net_, 7), offsets); });
  }
}

TEST(NetSmoothing, SaysHowFarEachLabelMoved) {
  const testing::BuiltLabels labels({3, 1, 1}, std::vector<std::uint8_t>{1, 1, 2});
  NetCollector collector;
  NoProgress progress;
  extract_net(labels.reader(), 0, collector, progress);
  const SurfaceNet net = collector.take();
  std::vector<NetOffset> offsets(net.points.size());
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    if (net.points[i] == NetPoint{0, 0, 0}) offsets[i] = {0.25f, 0, 0.5f};
  }
  const Geometry geometry{{0, 0, 0}, {2, 1, 0.5}, {0, 1, 0, 1, 0, 0, 0, 0, 1}};
  const auto moves = longest_moves_mm(net, offsets, geometry);
  ASSERT_EQ(moves.size(), 2u);
  EXPECT_NEAR(moves.at(1), std::hypot(0.5, 0.25), 1e-6);
  EXPECT_EQ(moves.at(2), 0);
}

}  // namespace
}  // namespace octavo
