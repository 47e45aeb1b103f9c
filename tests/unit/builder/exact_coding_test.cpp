#include "octavo/builder/exact_coding.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "octavo/builder/float_planes.h"
#include "octavo/planes/computed_source.h"

namespace octavo {
namespace {

constexpr Size3 kSize{32, 16, 160};
constexpr std::int64_t kFirstPlanes = 16;

VolumeDescription floats() {
  VolumeDescription description;
  description.type = VoxelType::float32;
  description.size = kSize;
  return description;
}

/// Voxels by their place in a plane and their plane, each asked for in this order.
std::unique_ptr<PlaneSource> source_of(const std::function<float(std::int64_t, std::int64_t)>& f) {
  const auto fill = [f](const Box& box, std::byte* voxels) {
    auto* out = reinterpret_cast<float*>(voxels);
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t i = 0; i < kSize.x * kSize.y; ++i) *out++ = f(i, z);
    }
  };
  return make_computed_source(floats(), fill, 1);
}

/// Noise that depends on the place alone.
float noise_at(std::int64_t i, std::int64_t z) {
  std::minstd_rand random(static_cast<std::uint32_t>(i + z * 7919 + 1));
  random.discard(3);
  return static_cast<float>(random()) / 2147483647.0f;
}

/// Reads every plane. Returns what only level 0 holds.
ClippedVoxels clipped_of(PlaneSource& source, SampleCoding* coding = nullptr) {
  NoProgress progress;
  FloatPlanes planes(source, {.first_planes = kFirstPlanes}, progress);
  if (coding != nullptr) *coding = planes.coding();
  std::vector<std::byte> plane(kSize.x * kSize.y * sizeof(float));
  for (std::int64_t z = 0; z < kSize.z; ++z) planes.read_plane(plane);
  return planes.clipped();
}

/// Air of 1e-7, and from plane 70 on a body of 5e4 that fills a share of each plane.
float positron(std::int64_t i, std::int64_t z, std::int64_t share) {
  return (z >= 70 && i % share == 0 ? 5e4f : 1e-7f) * noise_at(i, z);
}

class NoSeek final : public PlaneSource {
 public:
  explicit NoSeek(std::unique_ptr<PlaneSource> source) : source_(std::move(source)) {}
  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  void read_plane(std::span<std::byte> plane) override { source_->read_plane(plane); }
  bool can_seek() const override { return false; }
  void seek(std::int64_t, std::int64_t) override { FAIL() << "it was sought"; }

 private:
  std::unique_ptr<PlaneSource> source_;
};

TEST(ExactCoding, LaterPlanesHaveTheirSayInTheStep) {
  for (const std::int64_t share : {2, 9, 40}) {
    const auto source = source_of([share](std::int64_t i, std::int64_t z) {
      return positron(i, z, share);
    });
    SampleCoding coding;
    EXPECT_EQ(clipped_of(*source, &coding), ClippedVoxels{}) << share;
    EXPECT_LE(coding.scale, 0.1) << share;
  }
}

TEST(ExactCoding, TheLimitIsTheFartherEndOfTheCodes) {
  for (const double offset : {0.0, 100.0, -100.0}) {
    const SampleCoding coding{VoxelType::int32, 0.5, offset, true};
    ClippedVoxels clipped;
    const std::vector<float> voxels = {3, 1e20f};
    count_clipped(coding, voxels, clipped);
    EXPECT_EQ(clipped.count, 1) << offset;
    EXPECT_EQ(clipped.limit, 0.5 * (0x1p31 - 2) + 100 * (offset != 0 ? 1 : 0)) << offset;
  }
}

TEST(ExactCoding, WhatNoPlaneAnnouncedIsCountedWithTheFarthest) {
  const auto source = source_of([](std::int64_t i, std::int64_t z) {
    if (z == 159 && i == 5) return -1e20f;
    if (z == 159 && i < 5) return 1e19f;
    return 10 + noise_at(i, z);
  });
  SampleCoding coding;
  const ClippedVoxels clipped = clipped_of(*source, &coding);
  EXPECT_EQ(clipped.count, 6);
  EXPECT_EQ(clipped.farthest, -1e20f);
  EXPECT_EQ(clipped.limit, coding.scale * (0x1p31 - 2));
  EXPECT_LT(coding.scale, 0.1);
}

TEST(ExactCoding, FillsAreCountedAndHaveNoSay) {
  constexpr float kFill = -std::numeric_limits<float>::max();
  const auto source = source_of([](std::int64_t i, std::int64_t z) {
    return i % 3 == 0 ? kFill : 10 + noise_at(i, z);
  });
  SampleCoding coding;
  const ClippedVoxels clipped = clipped_of(*source, &coding);
  EXPECT_EQ(clipped.count, (kSize.x * kSize.y + 2) / 3 * kSize.z);
  EXPECT_EQ(clipped.farthest, kFill);
  EXPECT_LT(coding.scale, 0.1);
}

TEST(ExactCoding, InfinitiesAndNanAreNotCounted) {
  const auto source = source_of([](std::int64_t i, std::int64_t z) {
    if (i == 3) return std::numeric_limits<float>::infinity();
    return i == 4 ? std::nanf("") : noise_at(i, z);
  });
  EXPECT_EQ(clipped_of(*source).count, 0);
}

TEST(ExactCoding, ASourceThatCannotSeekIsReadOnce) {
  NoSeek source(source_of([](std::int64_t i, std::int64_t z) { return positron(i, z, 2); }));
  const ClippedVoxels clipped = clipped_of(source);
  EXPECT_GT(clipped.count, 0);
  EXPECT_GT(clipped.farthest, 4e4f);
}

TEST(ExactCoding, ANumberThatAllPlanesAreMultiplesOfGoesBeforeThatOfTheFirst) {
  const auto source = source_of([](std::int64_t i, std::int64_t z) {
    const auto steps = std::floor(1000 * noise_at(i, z));
    return static_cast<float>(z < 40 ? steps : 0.1 * static_cast<double>(steps));
  });
  SampleCoding coding;
  clipped_of(*source, &coding);
  EXPECT_EQ(coding.scale, 0.1);
}

TEST(ExactCoding, TwoValuesLie32StepsApart) {
  const std::pair<float, float> pairs[] = {
      {-1000, 3071.5f}, {0.1f, 0.7300001f}, {1.5f, -3.4028235e38f}, {1, 1.0000001f}, {0, 255}};
  for (const auto& [one, other] : pairs) {
    const auto source = source_of([one = one, other = other](std::int64_t i, std::int64_t z) {
      return noise_at(i, z) < 0.3f ? one : other;
    });
    SampleCoding coding;
    EXPECT_EQ(clipped_of(*source, &coding).count, 0) << one;
    const double steps = (static_cast<double>(other) - static_cast<double>(one)) / coding.scale;
    EXPECT_NEAR(std::abs(steps), 32, 1e-5) << one;
  }
}

TEST(ExactCoding, StepsAreDividedUntilThereAre32) {
  constexpr float kFar = std::numeric_limits<float>::max();
  struct Case {
    std::vector<float> values;
    double scale;
    double finer;
  };
  const Case cases[] = {
      {{0, 1}, 1, 1.0 / 32},          {{5, 6}, 1, 1.0 / 32},      {{0, 1, 2, 3, 4}, 1, 0.125},
      {{0, 31}, 1, 0.5},              {{0, 32}, 1, 1},            {{-3, 900}, 1, 1},
      {{-kFar, 0, 1}, 1, 1.0 / 32},   {{0, 1, 1e8f}, 1, 1},       {{7}, 1, 1},
      {{}, 1, 1},                     {{16777214, 16777215}, 1, 1.0 / 32},
  };
  for (const Case& one : cases) {
    const SampleCoding coding{VoxelType::int32, one.scale, 0, true};
    const SampleCoding finer = with_steps_for_means(coding, one.values);
    EXPECT_EQ(finer.scale, one.finer) << (one.values.empty() ? 0 : one.values.back());
    EXPECT_EQ(with_steps_for_means(finer, one.values), finer);
  }
}

TEST(ExactCoding, FewArbitraryValuesHaveFewCodes) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(0, 1);
  std::vector<float> values;
  for (int i = 0; i < 8; ++i) values.push_back(any(random));
  const auto [low, high] = std::ranges::minmax(values);
  const auto source = source_of([&](std::int64_t i, std::int64_t z) {
    return values[static_cast<std::size_t>(8 * noise_at(i / 4, z / 4)) % 8];
  });
  SampleCoding coding;
  clipped_of(*source, &coding);
  const double codes = static_cast<double>(high - low) / coding.scale;
  EXPECT_GE(codes, 16);
  EXPECT_LE(codes, 257);
}

TEST(ExactCoding, OfASourceThatCannotSeekTwoValuesAreNoMask) {
  const auto value = [](std::int64_t i, std::int64_t z) {
    return z < 2 * kFirstPlanes ? (i % 3 == 0 ? -1024.0f : 3.25f) : 100 * noise_at(i, z);
  };
  NoSeek source(source_of(value));
  SampleCoding coding;
  clipped_of(source, &coding);
  EXPECT_LT(coding.scale, 1);
}

}  // namespace
}  // namespace octavo
