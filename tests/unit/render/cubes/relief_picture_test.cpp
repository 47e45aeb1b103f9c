#include "octavo/render/cubes/relief_picture.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <cstring>
#include <random>

#include "support/built_file.h"
#include "support/dense_mask.h"
#include "support/memory_reader.h"
#include "support/read_png.h"

namespace octavo {
namespace {

using testing::DenseMask;
using testing::pixel;

constexpr Size3 kReliefSize = {64, 60, 56};
constexpr Color kGround = {10, 20, 60};

template <class Inside>
MaskTree mask_of(Inside inside) {
  const auto voxels = static_cast<std::size_t>(kReliefSize.voxel_count());
  DenseMask mask{kReliefSize, std::vector<std::uint8_t>(voxels)};
  testing::for_each_voxel(kReliefSize, [&](const Index3& p) { mask.at(p) = inside(p) ? 1 : 0; });
  return testing::tree_of(mask);
}

double from_middle(const Index3& p) {
  return std::hypot(static_cast<double>(p.x) - 31.5, static_cast<double>(p.y) - 29.5,
                    static_cast<double>(p.z) - 27.5);
}

MaskTree ball(double radius) {
  return mask_of([&](const Index3& p) { return from_middle(p) < radius; });
}

/// Smaller where it is farther from the middle.
std::unique_ptr<FileReader> hill(int sign = 1) {
  VolumeDescription description;
  description.type = VoxelType::int16;
  description.size = kReliefSize;
  std::vector<std::byte> voxels(static_cast<std::size_t>(2 * kReliefSize.voxel_count()));
  std::size_t at = 0;
  testing::for_each_voxel(kReliefSize, [&](const Index3& p) {
    const auto value = static_cast<std::int16_t>(sign * (1000 - std::lround(20 * from_middle(p))));
    std::memcpy(voxels.data() + at, &value, 2);
    at += 2;
  });
  return std::make_unique<testing::MemoryReader>(description, voxels, ValueRange{-1000, 1000});
}

View looking_from(const Viewpoint& viewpoint, std::int64_t side = 120) {
  // The ball is in the middle, and as large from every side.
  return make_view({}, kReliefSize, {{11, 9, 7}, {53, 51, 49}}, viewpoint, {side, side, 1, 0.5});
}

CubeStyle style() { return {kGround, 0, box_of(kReliefSize)}; }

Picture relief(const MaskTree& tree, const View& view, const ReliefField* field = nullptr,
               const Box& kept = box_of(kReliefSize)) {
  const PaintedMask painted{&tree, {200, 180, 160}};
  const MaskTree* const masks[] = {&tree};
  const auto own = mask_relief(masks);
  return draw_relief({&painted, 1}, view, style(), field != nullptr ? *field : *own, kept);
}

/// Mean difference of the first channel over pixels that both pictures draw.
double mean_difference(const Picture& a, const Picture& b) {
  double sum = 0, count = 0;
  for (std::int64_t y = 0; y < a.height; ++y) {
    for (std::int64_t x = 0; x < a.width; ++x) {
      if (pixel(a, x, y) == kGround || pixel(b, x, y) == kGround) continue;
      sum += std::abs(int{pixel(a, x, y)[0]} - int{pixel(b, x, y)[0]});
      ++count;
    }
  }
  return sum / count;
}

TEST(ReliefField, SmoothingIsAGaussianMean) {
  std::mt19937 random(3);
  const MaskTree tree = mask_of([&](const Index3&) { return random() % 3 == 0; });
  const MaskTree* const masks[] = {&tree};
  const auto field = mask_relief(masks);
  const Box box{{-2, 3, 50}, {9, 10, 60}};  // beyond two borders
  const std::vector<float> found = smoothed(*field, 0, box);
  const double deviation = field->smoothing();
  const auto reach = static_cast<std::int64_t>(std::ceil(2.5 * deviation));
  std::size_t i = 0;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
        double sum = 0, weights = 0;
        for (std::int64_t w = -reach; w <= reach; ++w) {
          for (std::int64_t v = -reach; v <= reach; ++v) {
            for (std::int64_t u = -reach; u <= reach; ++u) {
              const double weight = std::exp(-static_cast<double>(u * u + v * v + w * w) /
                                             (2 * deviation * deviation));
              weights += weight;
              sum += tree.contains({x + u, y + v, z + w}) ? weight : 0;
            }
          }
        }
        ASSERT_NEAR(found[i++], sum / weights, 1e-5);
      }
    }
  }
}

TEST(ReliefField, GreyValuesGoOnBeyondTheBorder) {
  const auto reader = hill();
  const auto field = grey_relief(*reader, 0, {{100, 2000}});
  const Box box{{-3, 57, 20}, {4, 63, 22}};
  std::vector<float> values(static_cast<std::size_t>(box.size().voxel_count()));
  field->read(0, box, values.data());
  std::size_t i = 0;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
        const Index3 held{std::max<std::int64_t>(x, 0), std::min<std::int64_t>(y, 59), z};
        const auto value = static_cast<float>(1000 - std::lround(20 * from_middle(held)));
        ASSERT_EQ(values[i++], std::min(value - 100, 2000 - value));
      }
    }
  }
}

TEST(ReliefPicture, ShowsWhatThePictureOfCubesShows) {
  const MaskTree tree = ball(19);
  for (const auto& [azimuth, elevation] : {std::pair{20.0, 30.0}, std::pair{0.0, 0.0}}) {
    const Viewpoint viewpoint = viewpoint_at(azimuth, elevation);
    const Picture found = relief(tree, looking_from(viewpoint));
    // Four points per pixel, on the same units.
    View fine = looking_from(viewpoint);
    --fine.fraction_bits;
    fine.width *= 2;
    fine.height *= 2;
    const PaintedMask painted{&tree, {255, 255, 255}};
    const Picture cubes = draw_nearest_cubes({&painted, 1}, fine, style());
    for (std::int64_t y = 0; y < found.height; ++y) {
      for (std::int64_t x = 0; x < found.width; ++x) {
        bool is_ground = true;
        for (int i = 0; i < 4; ++i) {
          is_ground = is_ground && pixel(cubes, 2 * x + i % 2, 2 * y + i / 2) == kGround;
        }
        ASSERT_EQ(pixel(found, x, y) == kGround, is_ground);
      }
    }
  }
}

TEST(ReliefPicture, ABallLooksTheSameFromEverySide) {
  const MaskTree tree = ball(20);
  const Picture front = relief(tree, looking_from(*find_viewpoint("front")));
  const PaintedMask painted{&tree, {200, 180, 160}};
  const Picture flat_front =
      draw_nearest_cubes({&painted, 1}, looking_from(*find_viewpoint("front")), style());
  for (const char* side : {"left", "top", "left-front", "left-front-top", "back-bottom"}) {
    const View view = looking_from(*find_viewpoint(side));
    EXPECT_LT(mean_difference(front, relief(tree, view)), 4) << side;
    if (std::string(side).find('-') == std::string::npos) continue;
    EXPECT_GT(mean_difference(flat_front, draw_nearest_cubes({&painted, 1}, view, style())), 8);
  }
}

TEST(ReliefPicture, ASlantedPlaneHasOneShade) {
  const MaskTree tree = mask_of([](const Index3& p) { return 2 * p.x + 3 * p.y - p.z > 90; });
  const Viewpoint viewpoint = viewpoint_along({}, {-2, -3, 1});
  const Picture picture = relief(tree, looking_from(viewpoint));
  int low = 255, high = 0;
  for (std::int64_t y = 50; y < 70; ++y) {
    for (std::int64_t x = 50; x < 70; ++x) {
      low = std::min<int>(low, pixel(picture, x, y)[0]);
      high = std::max<int>(high, pixel(picture, x, y)[0]);
    }
  }
  EXPECT_LT(high - low, 8);
  EXPECT_GT(low, 100);
}

TEST(ReliefPicture, GreyValuesGiveTheReliefOfTheirMask) {
  const auto reader = hill();
  const auto field = grey_relief(*reader, 0, {{601, 2000}});
  const MaskTree tree = ball(20);
  const View view = looking_from(*find_viewpoint("right-front-top"));
  const Picture of_mask = relief(tree, view);
  EXPECT_LT(mean_difference(of_mask, relief(tree, view, field.get())), 4);
  // Values that rise outwards have the same surface.
  const View into = looking_from(*find_viewpoint("front"));
  const Box kept{{0, 30, 0}, {64, 60, 56}};
  const MaskTree half =
      mask_of([&](const Index3& p) { return kept.contains(p) && from_middle(p) >= 20; });
  const auto around = grey_relief(*reader, 0, {{-2000, 600}});
  const Picture bowl = relief(half, into, around.get(), kept);
  const Picture mask_bowl = relief(half, into);
  std::int64_t compared = 0;
  double sum = 0;
  for (std::int64_t y = 45; y < 75; ++y) {
    for (std::int64_t x = 45; x < 75; ++x) {
      sum += std::abs(int{pixel(bowl, x, y)[0]} - int{pixel(mask_bowl, x, y)[0]});
      ++compared;
    }
  }
  EXPECT_LT(sum / static_cast<double>(compared), 6);
}

TEST(ReliefPicture, ValuesThatRiseOutwardsGiveTheSamePicture) {
  const auto rising = hill();
  const auto falling = hill(-1);
  const MaskTree tree = ball(20);
  for (const char* const side : {"back", "left-front-top"}) {
    const View view = looking_from(*find_viewpoint(side), 200);
    const auto into = grey_relief(*rising, 0, {{601, 5000}});
    const auto out = grey_relief(*falling, 0, {{-5000, -601}});
    EXPECT_EQ(relief(tree, view, into.get()).pixels, relief(tree, view, out.get()).pixels) << side;
  }
}

TEST(ReliefPicture, ACutThroughGreyValuesIsFlat) {
  const auto reader = hill();
  const auto field = grey_relief(*reader, 0, {{601, 2000}});
  const Box kept{{0, 25, 0}, {64, 60, 56}};
  const MaskTree tree =
      mask_of([&](const Index3& p) { return kept.contains(p) && from_middle(p) < 20; });
  const Picture picture = relief(tree, looking_from(*find_viewpoint("front")), field.get(), kept);
  const Color middle = pixel(picture, 60, 60);
  for (std::int64_t y = 40; y < 80; ++y) {
    for (std::int64_t x = 40; x < 80; ++x) ASSERT_EQ(pixel(picture, x, y), middle);
  }
}

TEST(ReliefPicture, ThreadsDoNotChangeThePicture) {
  const MaskTree tree = ball(18);
  const View view = looking_from(viewpoint_at(33, 21), 260);
  std::vector<Picture> pictures;
  for (const int threads : {1, 2, 5}) {
    tbb::task_arena(threads).execute([&] { pictures.push_back(relief(tree, view)); });
  }
  EXPECT_EQ(pictures[0].pixels, pictures[1].pixels);
  EXPECT_EQ(pictures[0].pixels, pictures[2].pixels);
}

TEST(ReliefPicture, NothingIsBackground) {
  const MaskTree tree(kReliefSize);
  const Picture picture = relief(tree, looking_from(*find_viewpoint("front")));
  for (std::int64_t i = 0; i < 120 * 120; ++i) ASSERT_EQ(pixel(picture, i % 120, i / 120), kGround);
}

}  // namespace
}  // namespace octavo
