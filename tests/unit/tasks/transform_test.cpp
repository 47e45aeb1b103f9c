#include "octavo/tasks/transform.h"

#include <random>

#include "octavo/ops/grid/axis_turn.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;

constexpr Size3 kTransformSize = {68, 25, 19};

class Transform : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(23);
    const auto below = [&](std::int64_t n) {
      return static_cast<std::int64_t>(random() % 1000) % n;
    };
    for (std::int32_t box = 0; box < 60; ++box) {
      const Index3 lo = {below(kTransformSize.x), below(kTransformSize.y), below(kTransformSize.z)};
      labels_.fill({lo, {lo.x + 9, lo.y + 7, lo.z + 5}}, box % 5);
    }
    options_.input = write("labels.8vo", labels_);
    options_.output = {folder_.file("out.8vo"), true};
  }

  TransformResult apply(const TransformStep& step) {
    options_.step = step;
    return transform(options_, context_);
  }

  DenseLabels result() const { return read(options_.output.path); }

  /// The label at `p`, or `outside` where that is none of the volume.
  std::int32_t label_at(const Index3& p, std::int32_t outside) const {
    return box_of(kTransformSize).contains(p) ? labels_.at(p) : outside;
  }

  DenseLabels labels_{kTransformSize};
  TransformOptions options_;
};

TEST_F(Transform, ATranslationMovesTheOriginAndNothingElse) {
  const TransformResult by_voxels = apply(TranslateStep{{2, -4, 10}});
  EXPECT_TRUE(by_voxels.is_copied);
  EXPECT_EQ(by_voxels.volume.geometry.origin_mm, (Point3{-9, 18, 25}));
  EXPECT_EQ(result(), labels_);
  const TransformResult by_mm = apply(TranslateMmStep{{1, 2, 3}});
  EXPECT_EQ(by_mm.volume.geometry.origin_mm, (Point3{-9, 22, 8}));
  EXPECT_EQ(result(), labels_);
}

TEST_F(Transform, AShiftDropsWhatFallsOutAndFillsWhatComesIn) {
  apply(ShiftStep{{5, -3, 4}, 9});
  EXPECT_EQ(result(), computed(kTransformSize, [&](const Index3& p) {
              return label_at({p.x - 5, p.y + 3, p.z - 4}, 9);
            }));
  EXPECT_TRUE(warnings_.empty());
  apply(ShiftStep{{0, 25, 0}, {}});
  EXPECT_EQ(result(), DenseLabels(kTransformSize));
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(Transform, TurnsMoveWholeVoxelsThatKeepTheirPlaceInSpace) {
  const std::pair<TransformStep, AxisTurn> turns[] = {
      {RotateStep{{{2, 90}}}, quarter_turns(2, 1)},
      {RotateStep{{{0, -90}, {1, 180}}}, chained(quarter_turns(0, -1), quarter_turns(1, 2))},
      {MirrorStep{{0, 2}}, chained(mirror_along(0), mirror_along(2))}};
  for (const auto& [step, turn] : turns) {
    const TransformResult turned_volume = apply(step);
    EXPECT_EQ(turned_volume.volume.size, turned(kTransformSize, turn));
    const DenseLabels made = result();
    EXPECT_EQ(made, computed(turned(kTransformSize, turn), [&, turn = turn](const Index3& p) {
                return labels_.at(source_of(p, kTransformSize, turn));
              }));
    const Index3 corner = source_of({0, 0, 0}, kTransformSize, turn);
    const Point3 place = geometry_.to_world({static_cast<double>(corner.x),
                                             static_cast<double>(corner.y),
                                             static_cast<double>(corner.z)});
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(turned_volume.volume.geometry.origin_mm[a], place[a], 1e-9);
    }
  }
}

TEST_F(Transform, ATurnInPlaceKeepsTheDirection) {
  const TransformResult made = apply(RotateStep{{{2, 90}}, true});
  EXPECT_EQ(made.volume.geometry.direction, geometry_.direction);
}

TEST_F(Transform, AMaskIsTurnedAndShiftedOnItsOctreeAsItsVoxelsAre) {
  const DenseLabels mask =
      computed(kTransformSize, [&](const Index3& p) { return labels_.at(p) == 1; });
  testing::Volume volume = volume_of(mask, 2);
  volume.description.type = VoxelType::uint8;
  volume.voxels.clear();
  for (const std::int32_t label : mask.voxels) {
    volume.voxels.push_back(static_cast<std::byte>(label));
  }
  options_.input = folder_.file("mask.8vo");
  testing::build_volume(volume, options_.input, 1);
  apply(MirrorStep{{1}});
  EXPECT_EQ(result(), computed(kTransformSize, [&](const Index3& p) {
              return mask.at({p.x, kTransformSize.y - 1 - p.y, p.z});
            }));
  apply(ShiftStep{{-7, 2, 0}, {}});
  EXPECT_EQ(result(), computed(kTransformSize, [&](const Index3& p) {
              const Index3 q = {p.x + 7, p.y - 2, p.z};
              return box_of(kTransformSize).contains(q) && mask.at(q) != 0;
            }));
}

TEST_F(Transform, AFinerGridRepeatsLabels) {
  const TransformResult made = apply(ScaleStep{.factor = 2});
  EXPECT_EQ(made.volume.size, (Size3{136, 50, 38}));
  EXPECT_EQ(result(), computed(made.volume.size, [&](const Index3& p) {
              return labels_.at({p.x / 2, p.y / 2, p.z / 2});
            }));
}

TEST_F(Transform, ACoarserGridIsThatOfALevel) {
  const auto reader = testing::open_file(options_.input);
  const TransformResult made = apply(ScaleStep{.factor = 4, .is_finer = false});
  EXPECT_EQ(made.volume.size, reader->levels().size(2));
  EXPECT_EQ(testing::read_box(*testing::open_file(options_.output.path),
                              box_of(made.volume.size), 0),
            testing::read_box(*reader, box_of(made.volume.size), 2));
  options_.input = write("small.8vo", DenseLabels({5, 4, 3}, 1));
  for (const std::int64_t factor : {3, 64, 128}) {
    const ScaleStep step{.factor = factor, .is_finer = false};
    EXPECT_EQ(failure_of([&] { apply(step); }).field, "step.factor");
  }
}

TEST_F(Transform, AMapByWholeVoxelsMovesTheObjectAsAShiftDoes) {
  ResampleStep step;
  step.map_mm = Affine{};
  step.map_mm->offset = {3 * 0.5, -2 * 0.5, 1 * 2};
  step.fill = 8;
  const auto expected = computed(kTransformSize, [&](const Index3& p) {
    return label_at({p.x - 3, p.y + 2, p.z - 1}, 8);
  });
  apply(step);
  EXPECT_EQ(result(), expected);
  step.map_mm = inverse(*step.map_mm);
  step.is_inverse = true;
  apply(step);
  EXPECT_EQ(result(), expected);
}

TEST_F(Transform, TheGridOfAnotherFileIsTakenOver) {
  geometry_.origin_mm = {-8, 20, 5};
  ResampleStep step;
  step.grid_of = write("grid.8vo", DenseLabels({10, 30, 19}, 1));
  const TransformResult made = apply(step);
  EXPECT_EQ(made.volume.geometry, geometry_);
  EXPECT_EQ(result(), computed({10, 30, 19}, [&](const Index3& p) {
              return label_at({p.x + 4, p.y, p.z}, 0);
            }));
  EXPECT_TRUE(warnings_.empty());
  geometry_.origin_mm = {500, 20, 5};
  step.grid_of = write("far.8vo", labels_);
  apply(step);
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(Transform, StepsThatTheVolumeDoesNotAllowAreRejected) {
  ResampleStep linear;
  linear.map_mm = Affine{};
  linear.interpolation = Interpolation::linear;
  ResampleStep flat;
  flat.map_mm = Affine{};
  flat.map_mm->linear[8] = 0;
  for (const auto& [step, field] : std::vector<std::pair<TransformStep, std::string>>{
           {linear, "step.interpolation"},
           {flat, "step.map_mm"},
           {ResampleStep{}, "step"},
           {ShiftStep{{1, 1, 1}, 0.5}, "step.fill"},
           {RotateStep{{{2, 45}}}, "step"},
           {MirrorStep{{3}}, "step.axis"}}) {
    EXPECT_EQ(failure_of([&, step = step] { apply(step); }).field, field);
  }
  options_.max_error = -1;
  EXPECT_EQ(failure_of([&] { apply(MirrorStep{{0}}); }).field, "max_error");
}

TEST_F(Transform, ResultsThatAreTooLargeAreRejectedBeforeAnyWork) {
  context_.max_memory_bytes = std::uint64_t{300} << 20;
  const Failure failure = failure_of([&] { apply(ScaleStep{.factor = 64}); });
  EXPECT_EQ(failure.kind, ErrorKind::limit_exceeded);
  EXPECT_EQ(failure.field, "max_memory_bytes");
  EXPECT_FALSE(std::filesystem::exists(options_.output.path));
}

}  // namespace
}  // namespace octavo
