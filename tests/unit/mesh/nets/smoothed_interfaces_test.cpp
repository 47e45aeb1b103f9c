#include "octavo/mesh/nets/smoothed_interfaces.h"

#include <gtest/gtest.h>

#include <cmath>

#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/nets/net_extraction.h"
#include "support/built_labels.h"

namespace octavo {
namespace {

class Mosaic : public ::testing::Test {
 protected:
  void SetUp() override {
    const Size3 size = {30, 24, 20};
    const testing::BuiltLabels labels(size, testing::random_labels(size, 3, 40, 5), geometry_);
    NetCollector collector;
    NoProgress progress;
    extract_net(labels.reader(), 0, collector, progress);
    net_ = collector.take();
  }

  /// The largest change of a volume, as a share of it.
  double largest_change(const InterfaceMesh& interfaces) const {
    double largest = 0;
    const auto counts = voxel_counts(net_, false);
    for (const auto& [label, volume] : enclosed_volumes(interfaces)) {
      const double before = 0.75 * static_cast<double>(counts.at(label));
      largest = std::max(largest, std::abs(volume / before - 1));
    }
    return largest;
  }

  Geometry geometry_{{10, 20, -30}, {0.5, 0.75, 2}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  SurfaceFrame frame_{geometry_, {30, 24, 20}};
  SurfaceNet net_;
};

TEST_F(Mosaic, EnclosesWhatItsPartsDo) {
  const InterfaceMesh made = interface_mesh(net_, smoothed_offsets(net_, 10), frame_);
  LabelParts parts(made);
  const auto volumes = enclosed_volumes(made);
  ASSERT_EQ(volumes.size(), parts.labels().size());
  for (const std::int64_t label : parts.labels()) {
    EXPECT_NEAR(measure_mesh(parts.cut(label)).volume_mm3, volumes.at(label), 1e-3);
  }
}

TEST_F(Mosaic, KeepsItsVolumes) {
  const InterfaceMesh free = interface_mesh(net_, smoothed_offsets(net_, 20), frame_);
  EXPECT_GT(largest_change(free), 0.01);
  for (const double most : {0.006, 0.002}) {
    const SmoothedInterfaces kept = smoothed_interfaces(net_, frame_, 20, most);
    EXPECT_LE(largest_change(kept.interfaces), most * (1 + 1e-9));
    EXPECT_EQ(interface_mesh(net_, kept.offsets, frame_).mesh, kept.interfaces.mesh);
  }
  const SmoothedInterfaces loose = smoothed_interfaces(net_, frame_, 20, 10);
  EXPECT_EQ(loose.interfaces.mesh, free.mesh);
}

}  // namespace
}  // namespace octavo
