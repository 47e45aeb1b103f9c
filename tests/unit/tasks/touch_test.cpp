#include "octavo/tasks/touch.h"

#include <map>
#include <random>

#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;
using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kTouchSize = {65, 23, 29};

class Touch : public testing::TaskFiles {};

TEST_F(Touch, MasksMeetWhereTheirVoxelsDo) {
  std::mt19937 random(17);
  const DenseMask a = testing::random_mask(kTouchSize, random);
  const DenseMask b = testing::random_mask(kTouchSize, random);
  VoxelExtent overlap;
  std::array<std::uint64_t, 3> faces{};
  for_each_voxel(kTouchSize, [&](const Index3& p) {
    if (a.at(p) != 0 && b.at(p) != 0) {
      ++overlap.voxel_count;
      overlap.box = united(overlap.box, {p, {p.x + 1, p.y + 1, p.z + 1}});
    }
    for (int axis = 0; axis < 3; ++axis) {
      Index3 q = p;
      if (++q[axis] == kTouchSize[axis]) continue;
      const int here = a.at(p) - b.at(p);
      const int there = a.at(q) - b.at(q);
      if (here * there < 0) ++faces[static_cast<std::size_t>(axis)];
    }
  });
  const TouchMasksResult result =
      touch_masks({write("a.8vo", a), write("b.8vo", b)}, context_);
  EXPECT_EQ(result.found.overlap, overlap);
  EXPECT_EQ(result.found.face_pairs, faces);
  const auto count = [&](std::size_t axis) { return static_cast<double>(faces[axis]); };
  EXPECT_DOUBLE_EQ(area_mm2(faces, result.volume).value(),
                   count(0) * 1 + count(1) * 1 + count(2) * 0.25);
}

TEST_F(Touch, LabelsMeetWhereTheirVoxelsDo) {
  std::mt19937 random(19);
  DenseLabels labels(kTouchSize);
  for (std::int32_t label = 1; label <= 12; ++label) {
    const auto below = [&](std::int64_t n) { return static_cast<std::int64_t>(random()) % n; };
    const Index3 lo = {below(50), below(15), below(20)};
    labels.fill({lo, {lo.x + 20, lo.y + 8, lo.z + 9}}, label);
  }
  std::map<std::pair<std::int64_t, std::int64_t>, std::uint64_t> pairs;
  for_each_voxel(kTouchSize, [&](const Index3& p) {
    for (const Index3& step : testing::neighbor_steps(18)) {
      const Index3 q = testing::moved(p, step);
      if (!box_of(kTouchSize).contains(q)) continue;
      const std::int64_t here = labels.at(p);
      const std::int64_t there = labels.at(q);
      if (here != 0 && here < there) ++pairs[{here, there}];
    }
  });
  const TouchLabelsResult result =
      touch_labels({write("labels.8vo", labels), Connectivity::edges}, context_);
  ASSERT_EQ(result.contacts.size(), pairs.size());
  for (const LabelContact& contact : result.contacts) {
    EXPECT_EQ(contact.voxel_pairs, pairs.at({contact.first, contact.second}));
  }
}

TEST_F(Touch, AnAreaNeedsASpacingAndMasksOneGrid) {
  const DenseLabels labels(kTouchSize, 1);
  const TouchLabelsResult result = touch_labels({write("unknown.8vo", labels, false)}, context_);
  EXPECT_FALSE(area_mm2({1, 2, 3}, result.volume).has_value());
  const std::string here = write("here.8vo", labels);
  geometry_.spacing_mm[1] *= 1.1;
  const std::string there = write("there.8vo", labels);
  EXPECT_EQ(failure_of([&] { touch_masks({here, there}, context_); }).field, "grid");
}

}  // namespace
}  // namespace octavo
