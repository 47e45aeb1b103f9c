#include "octavo/tasks/transform.h"

#include <cmath>
#include <random>

#include "octavo/ops/grid/axis_turn.h"
#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseLabels;

constexpr Size3 kTransformSize = {68, 25, 19};
constexpr Point3 kAboutX = {1, 0, 0};
constexpr Point3 kAboutY = {0, 1, 0};
constexpr Point3 kAboutZ = {0, 0, 1};

/// A point turned about an axis through the origin, right-handed.
Point3 turned_point(const Point3& p, Point3 axis, double degrees) {
  const double length = std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
  for (double& part : axis) part /= length;
  const double angle = degrees * std::acos(-1.0) / 180;
  const Point3 cross = {axis[1] * p[2] - axis[2] * p[1], axis[2] * p[0] - axis[0] * p[2],
                        axis[0] * p[1] - axis[1] * p[0]};
  const double dot = axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
  Point3 result{};
  for (std::size_t i = 0; i < 3; ++i) {
    result[i] = p[i] * std::cos(angle) + cross[i] * std::sin(angle) +
                axis[i] * dot * (1 - std::cos(angle));
  }
  return result;
}

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

  TransformResult apply(const TransformStep& step) { return apply_all({step}); }

  TransformResult apply_all(const std::vector<TransformStep>& steps) {
    options_.steps = steps;
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
  options_.fill = 9;
  apply(ShiftStep{{5, -3, 4}});
  EXPECT_EQ(result(), computed(kTransformSize, [&](const Index3& p) {
              return label_at({p.x - 5, p.y + 3, p.z - 4}, 9);
            }));
  EXPECT_TRUE(warnings_.empty());
  options_.fill.reset();
  apply(ShiftStep{{0, 25, 0}});
  EXPECT_EQ(result(), DenseLabels(kTransformSize));
  EXPECT_EQ(warnings_.size(), 1u);
}

TEST_F(Transform, TurnsMoveWholeVoxelsThatKeepTheirPlaceInSpace) {
  const std::pair<TransformStep, AxisTurn> turns[] = {
      {RotateStep{{{kAboutZ, 90}}}, quarter_turns(2, 1)},
      {RotateStep{{{kAboutX, -90}, {kAboutY, 180}}},
       chained(quarter_turns(0, -1), quarter_turns(1, 2))},
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
  const TransformResult made = apply(RotateStep{{{kAboutZ, 90}}, true});
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
  // Too little for a build of planes.
  context_.max_memory_bytes = std::uint64_t{160} << 20;
  apply(MirrorStep{{1}});
  EXPECT_EQ(result(), computed(kTransformSize, [&](const Index3& p) {
              return mask.at({p.x, kTransformSize.y - 1 - p.y, p.z});
            }));
  apply(ShiftStep{{-7, 2, 0}});
  const auto written = testing::open_file(options_.output.path);
  volume.description = written->description();
  volume.voxels = testing::read_box(*written, box_of(kTransformSize), 0);
  testing::build_volume(volume, folder_.file("planes.8vo"), 1);
  EXPECT_EQ(testing::bytes_of_file(options_.output.path),
            testing::bytes_of_file(folder_.file("planes.8vo")));
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
  AffineStep step;
  step.map_mm.offset = {3 * 0.5, -2 * 0.5, 1 * 2};
  options_.fill = 8;
  const auto expected = computed(kTransformSize, [&](const Index3& p) {
    return label_at({p.x - 3, p.y + 2, p.z - 1}, 8);
  });
  apply(step);
  EXPECT_EQ(result(), expected);
  step.map_mm = inverse(step.map_mm).value();
  step.is_inverse = true;
  apply(step);
  EXPECT_EQ(result(), expected);
}

TEST_F(Transform, TheGridOfAnotherFileIsTakenOver) {
  geometry_.origin_mm = {-8, 20, 5};
  options_.grid_of = write("grid.8vo", DenseLabels({10, 30, 19}, 1));
  const TransformResult made = apply_all({});
  EXPECT_EQ(made.volume.geometry, geometry_);
  EXPECT_EQ(result(), computed({10, 30, 19}, [&](const Index3& p) {
              return label_at({p.x + 4, p.y, p.z}, 0);
            }));
  EXPECT_TRUE(warnings_.empty());
  geometry_.origin_mm = {500, 20, 5};
  options_.grid_of = write("far.8vo", labels_);
  apply_all({});
  EXPECT_EQ(warnings_.size(), 1u);
}

/// By brute force: every voxel of the new grid, from the center, in mm, turned back.
TEST_F(Transform, AnyAngleAboutAnyAxisTurnsLabelsInMm) {
  const AxisRotation rotations[] = {
      {kAboutZ, 30}, {kAboutX, -77.5}, {{1, 1, 0}, 30}, {{-2, 1, 0.5}, 200}};
  for (const AxisRotation& rotation : rotations) {
    for (const bool is_in_place : {true, false}) {
      const TransformResult made = apply(RotateStep{{rotation}, is_in_place});
      const Size3& size = made.volume.size;
      const Geometry& grid = made.volume.geometry;
      EXPECT_EQ(grid.direction == geometry_.direction, is_in_place);
      const DenseLabels found = result();
      std::int64_t wrong = 0;
      std::int64_t inside = 0;
      testing::for_each_voxel(size, [&](const Index3& p) {
        Point3 from_center{};
        for (int a = 0; a < 3; ++a) {
          const auto i = static_cast<std::size_t>(a);
          from_center[i] = (static_cast<double>(p[a]) - static_cast<double>(size[a] - 1) / 2) *
                           grid.spacing_mm[i];
        }
        const Point3 before = turned_point(from_center, rotation.axis, -rotation.degrees);
        Index3 source;
        bool is_on_border = false;
        Point3 index{};
        for (int a = 0; a < 3; ++a) {
          const auto i = static_cast<std::size_t>(a);
          index[i] = before[i] / geometry_.spacing_mm[i] +
                     static_cast<double>(kTransformSize[a] - 1) / 2;
          source[a] = static_cast<std::int64_t>(std::floor(index[i] + 0.5));
          const double border = index[i] + 0.5;
          is_on_border = is_on_border || std::abs(border - std::round(border)) < 1e-5;
        }
        if (is_on_border) return;
        inside += box_of(kTransformSize).contains(source);
        wrong += found.at(p) != label_at(source, 0);
        if (is_in_place) return;
        // The place in space is the same.
        const Point3 here = grid.to_world({static_cast<double>(p.x), static_cast<double>(p.y),
                                           static_cast<double>(p.z)});
        const Point3 there = geometry_.to_world(index);
        for (std::size_t i = 0; i < 3; ++i) wrong += std::abs(here[i] - there[i]) > 1e-9;
      });
      EXPECT_EQ(wrong, 0) << rotation.degrees;
      // The new grid holds the whole volume: as many mm3 of it lie in the source.
      double mm3 = 1;
      for (const double mm : grid.spacing_mm) mm3 *= mm;
      const double volume = static_cast<double>(kTransformSize.voxel_count()) * 0.5;
      EXPECT_NEAR(static_cast<double>(inside) * mm3, volume, 0.02 * volume) << rotation.degrees;
    }
  }
}

TEST_F(Transform, AnglesThatAddUpToQuartersMoveWholeVoxels) {
  const TransformResult quarter = apply(RotateStep{{{kAboutZ, 90}}});
  const DenseLabels expected = result();
  const TransformResult thirds =
      apply_all({RotateStep{{{kAboutZ, 30}}}, TranslateStep{{0, 0, 0}},
                 RotateStep{{{kAboutZ, 60}}}});
  EXPECT_EQ(result(), expected);
  EXPECT_EQ(thirds.volume.size, quarter.volume.size);
  EXPECT_EQ(thirds.volume.geometry.direction, quarter.volume.geometry.direction);
  // About the diagonal x becomes y, y becomes z, and z becomes x.
  const TransformResult diagonal = apply(RotateStep{{{{1, 1, 1}, 120}}});
  EXPECT_EQ(diagonal.volume.size, (Size3{kTransformSize.z, kTransformSize.x, kTransformSize.y}));
  EXPECT_EQ(result(), computed(diagonal.volume.size, [&](const Index3& p) {
              return labels_.at({p.y, p.z, p.x});
            }));
}

TEST_F(Transform, StepsAreDoneInTheirOrderAndOnlyTheLastGridDropsVoxels) {
  const RotateStep quarter{{{kAboutZ, 90}}};
  // Turned: (x, y) was (y, 24 - x).
  apply_all({quarter, ShiftStep{{3, 0, 0}}});
  EXPECT_EQ(result(), computed({25, 68, 19}, [&](const Index3& p) {
              return p.x < 3 ? 0 : labels_.at({p.y, 24 - (p.x - 3), p.z});
            }));
  const TransformResult other = apply_all({ShiftStep{{3, 0, 0}}, quarter, MirrorStep{{2}}});
  EXPECT_EQ(other.operation, "shift, rotate, mirror");
  EXPECT_EQ(result(), computed({25, 68, 19}, [&](const Index3& p) {
              return label_at({p.y - 3, 24 - p.x, 18 - p.z}, 0);
            }));
  apply_all({ShiftStep{{60, 20, -19}}, ShiftStep{{-60, -20, 19}}, TranslateStep{{1, 0, 0}}});
  EXPECT_EQ(result(), labels_);
  EXPECT_TRUE(warnings_.empty());
}

TEST_F(Transform, AMaskDoesStepsOfWholeVoxelsOnItsOctreeAsItsVoxelsDo) {
  const DenseLabels mask =
      computed(kTransformSize, [&](const Index3& p) { return labels_.at(p) == 2; });
  testing::Volume volume = volume_of(mask, 2);
  volume.description.type = VoxelType::uint8;
  volume.voxels.clear();
  for (const std::int32_t label : mask.voxels) volume.voxels.push_back(std::byte(label));
  options_.input = folder_.file("mask.8vo");
  testing::build_volume(volume, options_.input, 1);
  const std::vector<TransformStep> steps = {ShiftStep{{-4, 3, 2}}, RotateStep{{{kAboutY, 90}}},
                                            ShiftStep{{1, 0, -30}}, MirrorStep{{0, 1}}};
  apply_all(steps);
  const DenseLabels on_tree = result();
  options_.input = write("wide.8vo", mask);  // int32 goes voxel by voxel
  apply_all(steps);
  EXPECT_EQ(result(), on_tree);
  EXPECT_NE(on_tree, DenseLabels(on_tree.size));
}

TEST(TransformSteps, RotationsThatFollowOneAnotherBecomeOneStepAndSoDoMirrors) {
  std::vector<TransformStep> steps;
  add_step(RotateStep{{{kAboutZ, 30}}}, steps);
  add_step(RotateStep{{{kAboutX, 60}}}, steps);
  add_step(MirrorStep{{0}}, steps);
  add_step(MirrorStep{{2}}, steps);
  add_step(RotateStep{{{kAboutY, 90}}}, steps);
  add_step(RotateStep{{{kAboutY, 90}}, true}, steps);
  add_step(ShiftStep{{1, 2, 3}}, steps);
  add_step(ShiftStep{{1, 2, 3}}, steps);
  ASSERT_EQ(steps.size(), 6U);
  const auto& rotations = std::get<RotateStep>(steps[0]).rotations;
  ASSERT_EQ(rotations.size(), 2U);
  EXPECT_EQ(rotations[0].degrees, 30);
  EXPECT_EQ(rotations[1].degrees, 60);
  EXPECT_EQ(std::get<MirrorStep>(steps[1]).axes, (std::vector<int>{0, 2}));
  EXPECT_FALSE(std::get<RotateStep>(steps[2]).is_in_place);
  EXPECT_TRUE(std::get<RotateStep>(steps[3]).is_in_place);
}

TEST_F(Transform, ValuesAreInterpolatedOnceForAllSteps) {
  testing::Volume volume = volume_of(labels_, 2);
  volume.description.kind = VolumeKind::grey;
  options_.input = folder_.file("grey.8vo");
  testing::build_volume(volume, options_.input, 1);
  AffineStep there;
  there.map_mm.offset = {0.37, -0.21, 0.44};
  AffineStep back = there;
  back.is_inverse = true;
  options_.interpolation = Interpolation::cubic;
  EXPECT_FALSE(apply_all({there, back}).is_copied);
  EXPECT_EQ(result(), labels_);
  apply(there);
  EXPECT_NE(result(), labels_);
}

TEST_F(Transform, ALevelIsTakenBeforeOtherSteps) {
  const ScaleStep half{.factor = 2, .is_finer = false};
  const TransformResult level = apply(half);
  const DenseLabels coarse = result();
  const Size3& size = level.volume.size;
  apply_all({half, RotateStep{{{kAboutZ, 180}}}});
  EXPECT_EQ(result(), computed(size, [&](const Index3& p) {
              return coarse.at({size.x - 1 - p.x, size.y - 1 - p.y, p.z});
            }));
  const RotateStep turn{{{kAboutZ, 180}}};
  EXPECT_EQ(failure_of([&] { apply_all({turn, half}); }).field, "step.factor");
}

TEST_F(Transform, StepsThatTheVolumeDoesNotAllowAreRejected) {
  AffineStep flat;
  flat.map_mm.linear[8] = 0;
  const double infinite = std::numeric_limits<double>::infinity();
  for (const auto& [step, field] : std::vector<std::pair<TransformStep, std::string>>{
           {flat, "step.map_mm"},
           {RotateStep{{{{0, 0, 0}, 45}}}, "step"},
           {RotateStep{{{kAboutZ, infinite}}}, "step"},
           {MirrorStep{{3}}, "step.axis"}}) {
    EXPECT_EQ(failure_of([&, step = step] { apply(step); }).field, field);
  }
  EXPECT_EQ(failure_of([&] { apply_all({}); }).field, "steps");
  options_.fill = 0.5;
  EXPECT_EQ(failure_of([&] { apply(ShiftStep{{1, 1, 1}}); }).field, "step.fill");
  options_.fill.reset();
  options_.interpolation = Interpolation::linear;
  EXPECT_EQ(failure_of([&] { apply(RotateStep{{{kAboutZ, 45}}}); }).field, "step.interpolation");
  options_.interpolation.reset();
  options_.grid_of = write("grid.8vo", labels_);
  EXPECT_EQ(failure_of([&] { apply(RotateStep{{{kAboutZ, 45}}}); }).field, "step.is_in_place");
  options_.grid_of.clear();
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
