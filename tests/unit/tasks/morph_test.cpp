#include "octavo/tasks/morph.h"

#include <random>

#include "support/task_files.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::for_each_voxel;

constexpr Size3 kMorphSize = {67, 20, 22};

class Morph : public testing::TaskFiles {
 protected:
  void SetUp() override {
    std::mt19937 random(9);
    mask_ = testing::random_mask(kMorphSize, random);
    options_.input = write("mask.8vo", mask_);
    options_.output = {folder_.file("out.8vo"), true};
  }

  /// Voxels of `mask` with value `spread` reach all within 1.2 mm: steps of 0.5, 0.5 and 2 mm.
  static DenseMask spread(const DenseMask& mask, std::uint8_t value) {
    DenseMask result = mask;
    for_each_voxel(kMorphSize, [&](const Index3& p) {
      if (mask.at(p) != value) return;
      for (std::int64_t y = -2; y <= 2; ++y) {
        for (std::int64_t x = -2; x <= 2; ++x) {
          const Index3 q = {p.x + x, p.y + y, p.z};
          const bool is_near = 0.25 * static_cast<double>(x * x + y * y) <= 1.2 * 1.2;
          if (is_near && box_of(kMorphSize).contains(q)) result.at(q) = value;
        }
      }
    });
    return result;
  }

  DenseMask made() const {
    DenseMask mask{kMorphSize, {}};
    for (const std::int32_t label : read(options_.output.path).voxels) {
      mask.voxels.push_back(static_cast<std::uint8_t>(label));
    }
    return mask;
  }

  DenseMask mask_;
  MorphOptions options_;
};

TEST_F(Morph, ABallInMmReachesWhatLiesWithinIt) {
  options_.mm = 1.2;
  const std::pair<Morphology, DenseMask> cases[] = {
      {Morphology::dilate, spread(mask_, 1)},
      {Morphology::erode, spread(mask_, 0)},
      {Morphology::open, spread(spread(mask_, 0), 1)},
      {Morphology::close, spread(spread(mask_, 1), 0)}};
  for (const auto& [morphology, expected] : cases) {
    options_.morphology = morphology;
    const MorphResult result = morph(options_, context_);
    EXPECT_EQ(made(), expected) << word_of(morphology);
    const auto count = [](const DenseMask& mask) {
      return static_cast<std::uint64_t>(std::count(mask.voxels.begin(), mask.voxels.end(), 1));
    };
    EXPECT_EQ(result.voxels, count(expected));
    EXPECT_EQ(result.voxels_before, count(mask_));
  }
}

TEST_F(Morph, AStepReachesTheNeighbors) {
  options_.steps = 1;
  for (const int connectivity : {6, 18, 26}) {
    options_.connectivity = static_cast<Connectivity>(connectivity);
    DenseMask expected = mask_;
    for_each_voxel(kMorphSize, [&](const Index3& p) {
      for (const Index3& step : testing::neighbor_steps(connectivity)) {
        const Index3 q = testing::moved(p, step);
        if (mask_.at(p) != 0 && box_of(kMorphSize).contains(q)) expected.at(q) = 1;
      }
    });
    morph(options_, context_);
    EXPECT_EQ(made(), expected) << connectivity;
  }
}

TEST_F(Morph, AMaskOfWhichNothingIsLeftIsWarnedOf) {
  options_.morphology = Morphology::erode;
  options_.steps = 40;
  EXPECT_EQ(morph(options_, context_).voxels, 0u);
  ASSERT_EQ(warnings_.size(), 1u);
  EXPECT_NE(warnings_.front().find(options_.input), std::string::npos);
}

TEST_F(Morph, DistancesThatAreNoneAreInvalid) {
  options_.steps = -1;
  EXPECT_EQ(failure_of([&] { morph(options_, context_); }).kind, ErrorKind::invalid_argument);
  options_.mm = -0.5;
  EXPECT_EQ(failure_of([&] { morph(options_, context_); }).kind, ErrorKind::invalid_argument);
  options_.mm = 1;
  options_.input = write("unknown.8vo", mask_, false);
  EXPECT_EQ(failure_of([&] { morph(options_, context_); }).field, "input.spacing_mm");
}

}  // namespace
}  // namespace octavo
