// The maximum error holds for every voxel, whatever the voxels are.
//
// Random bricks of every type, scans and adversaries, coded with models learned from other bricks,
// with every preset and random bounds.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

using octavo::testing::case_count;
using octavo::testing::GoalCases;
using Random = std::mt19937_64;

std::int64_t below(Random& random, std::int64_t n) {
  return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(n));
}

/// What a voxel is made from.
struct Recipe {
  int kind = 0;
  std::int64_t low = 0;     ///< smallest value
  std::int64_t span = 1;    ///< values above it
  std::int64_t grain = 1;   ///< noise on smooth ground
  std::int64_t period = 1;
};

Recipe draw_recipe(Random& random, std::int64_t lowest, std::int64_t highest) {
  Recipe r;
  r.kind = static_cast<int>(below(random, 7));
  const std::int64_t all = highest - lowest;
  // As often narrow as wide ranges, and both ends of the type among them.
  r.span = std::max<std::int64_t>(1, all >> below(random, 31));
  r.low = below(random, 3) == 0 ? highest - r.span : lowest + below(random, all - r.span + 1);
  r.grain = 1 + below(random, r.span);
  r.period = 1 + below(random, 9);
  return r;
}

std::int64_t voxel_of(const Recipe& r, const Index3& p, Random& random) {
  const auto smooth = [&] { return (p.x * 5 + p.y * 3 + p.z * 7) % 61 * (r.span / 61); };
  switch (r.kind) {
    case 0: return r.low + below(random, r.span + 1);                      // noise
    case 1: return r.low + (random() % 2 == 0 ? 0 : r.span);               // only extremes
    case 2: return r.low + ((p.x + p.y + p.z) % 2 == 0 ? 0 : r.span);      // checkerboard
    case 3: return r.low + std::min(r.span, smooth() + below(random, r.grain));
    case 4: return r.low + (p.x / r.period % 2 == 0 ? r.span : 0);         // stripes
    case 5: return r.low + (random() % 200 == 0 ? r.span : 0);             // lone peaks
    default: return r.low + std::min(r.span, smooth());                    // sawtooth
  }
}

template <class T>
class BoundsOf : public ::testing::Test {};
using Types = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t,
                             std::uint32_t>;
TYPED_TEST_SUITE(BoundsOf, Types);

template <class T>
struct Brick {
  BrickShape shape;
  std::vector<T> voxels;

  explicit Brick(Random& random) {
    const auto side = [&] { return below(random, 3) == 0 ? 1 + below(random, 64) : 64; };
    const Size3 size{side(), side(), side()};
    const Levels levels(size, choose_halvings(size, {1, 1, below(random, 4) == 0 ? 4.0 : 1.0}));
    shape = brick_shape(levels, 0, {0, 0, 0});
    voxels.resize(static_cast<std::size_t>(shape.size[0].voxel_count()));
    const Recipe recipe = draw_recipe(random, std::numeric_limits<T>::lowest(),
                                      std::numeric_limits<T>::max());
    T* out = voxels.data();
    const Size3& n = shape.size[0];
    for (std::int64_t z = 0; z < n.z; ++z) {
      for (std::int64_t y = 0; y < n.y; ++y) {
        for (std::int64_t x = 0; x < n.x; ++x) {
          *out++ = static_cast<T>(voxel_of(recipe, {x, y, z}, random));
        }
      }
    }
  }
  BrickView view() const {
    const Size3& n = shape.size[0];
    return {voxels.data(), voxel_type_of<T>(), n, n.x, n.x * n.y};
  }
};

/// The largest difference between the voxels of a brick and what comes back.
template <class T>
std::int64_t largest_error(const BrickCodec& codec, const Brick<T>& brick) {
  const EncodedBrick encoded = codec.encode(brick.shape, brick.view());
  const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
  std::vector<T> decoded(brick.voxels.size());
  codec.decode(brick.shape, voxel_type_of<T>(), encoded.range, segments, 0, decoded.data());
  std::int64_t most = 0;
  for (std::size_t i = 0; i < decoded.size(); ++i) {
    const auto found = static_cast<std::int64_t>(decoded[i]);
    most = std::max(most, std::abs(found - static_cast<std::int64_t>(brick.voxels[i])));
    if (found < encoded.range.min || found > encoded.range.max) {
      return std::numeric_limits<std::int64_t>::max();
    }
  }
  EXPECT_EQ(most, encoded.max_error);
  return most;
}

TYPED_TEST(BoundsOf, NoVoxelBreaksTheBound) {
  using T = TypeParam;
  Random random(sizeof(T) * 2 + std::numeric_limits<T>::is_signed);
  const std::int64_t highest = std::numeric_limits<T>::max();
  constexpr std::uint64_t kMillion = 1'000'000;
  // A sixth of all, for each type.
  GoalCases goal("F1", "million voxels within the bound", case_count(1, 1700));
  std::uint64_t voxels = 0;
  while (true) {
    const CodecSettings settings{below(random, 2) == 0 ? Preset::small : Preset::fast,
                                 below(random, 5) == 0 ? 0 : (highest >> below(random, 31)) / 2};
    const Brick<T> brick(random);
    const TrainingBrick training{brick.shape, brick.view()};
    const auto codec = train_grey_model(voxel_type_of<T>(), std::span(&training, 1), settings);
    ASSERT_LE(largest_error(*codec, brick), settings.max_error);
    for (int i = 0; i < 12; ++i) {
      const Brick<T> other(random);
      ASSERT_LE(largest_error(*codec, other), settings.max_error) << "after " << voxels;
      voxels += other.voxels.size();
    }
    while (goal.done() < voxels / kMillion) {
      if (!goal.next()) return;
    }
  }
}

}  // namespace
}  // namespace octavo
