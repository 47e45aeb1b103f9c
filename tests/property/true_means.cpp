// Coarse samples against the means of the voxels inside the volume, through the codec and tier by
// tier, on sizes at which border cells are only partly filled.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"

namespace octavo {
namespace {

/// A volume of noise with the sums of its voxels below every sample of a level.
struct Sums {
  Size3 size;
  std::vector<double> sum;
  std::vector<double> count;

  double mean(std::size_t i) const { return sum[i] / count[i]; }
};

Sums sums_below(const Sums& fine, HalvingMask mask) {
  Sums coarse{halved(fine.size, mask), {}, {}};
  coarse.sum.resize(static_cast<std::size_t>(coarse.size.voxel_count()));
  coarse.count.resize(coarse.sum.size());
  std::size_t i = 0;
  for (std::int64_t z = 0; z < fine.size.z; ++z) {
    for (std::int64_t y = 0; y < fine.size.y; ++y) {
      for (std::int64_t x = 0; x < fine.size.x; ++x, ++i) {
        const std::int64_t row = (z >> (mask >> 2 & 1)) * coarse.size.y + (y >> (mask >> 1 & 1));
        const auto at = static_cast<std::size_t>(row * coarse.size.x + (x >> (mask & 1)));
        coarse.sum[at] += fine.sum[i];
        coarse.count[at] += fine.count[i];
      }
    }
  }
  return coarse;
}

/// Puts one level of a brick into its place in the level of the volume.
template <class T>
void place(const Levels& levels, int level, const Index3& brick_at, const Size3& size,
           const std::vector<T>& samples, std::vector<T>& whole) {
  const int first = Levels::first_level(Levels::tier_of(level));
  Index3 at = brick_at;
  for (int axis = 0; axis < 3; ++axis) {
    at[axis] >>= levels.halving_count(level, axis) - levels.halving_count(first, axis);
  }
  const Size3& total = levels.size(level);
  const T* from = samples.data();
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y, from += size.x) {
      std::copy_n(from, size.x,
                  whole.data() + ((at.z + z) * total.y + at.y + y) * total.x + at.x);
    }
  }
}

/// Every level of a volume as the bricks of a codec give it back.
template <class T>
std::vector<std::vector<T>> decoded_levels(const BrickCodec& codec, const Levels& levels,
                                           std::vector<T> finest) {
  std::vector<std::vector<T>> result;
  for (int level = 0; level < levels.count(); ++level) {
    result.emplace_back(static_cast<std::size_t>(levels.size(level).voxel_count()));
  }
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    const Size3 grid = levels.brick_grid(tier);
    const Size3& total = levels.size(Levels::first_level(tier));
    std::vector<T> parents;
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const Index3 brick{i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)};
      const BrickShape shape = brick_shape(levels, tier, brick);
      const Index3 lo = levels.brick_box(tier, brick).lo;
      const BrickView view{finest.data() + (lo.z * total.y + lo.y) * total.x + lo.x,
                           voxel_type_of<T>(), shape.size[0], total.x, total.x * total.y};
      const EncodedBrick encoded = codec.encode(shape, view);
      const std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
      parents.push_back(static_cast<T>(encoded.parent));
      for (int in_brick = 0; in_brick < shape.level_count; ++in_brick) {
        const Size3& size = shape.size[static_cast<std::size_t>(in_brick)];
        std::vector<T> samples(static_cast<std::size_t>(size.voxel_count()));
        codec.decode(shape, view.type, encoded.range, segments, in_brick, samples.data());
        const int level = shape.first_level + in_brick;
        place(levels, level, lo, size, samples, result[static_cast<std::size_t>(level)]);
      }
    }
    finest = std::move(parents);
  }
  return result;
}

/// How far samples lie from the means of what is below them.
struct Deviations {
  double sum = 0;
  double count = 0;

  void add(double deviation) {
    sum += deviation;
    ++count;
  }
  double bias() const { return count > 0 ? sum / count : 0; }
  /// What chance may add to the bias: deviations scatter by less than 0.45.
  double chance() const { return 4 * 0.45 / std::sqrt(std::max(count, 1.0)); }
};

struct Case {
  Size3 size;
  Point3 spacing = {1, 1, 1};
};

const Case kCases[] = {{{3, 1, 1}},
                       {{1, 5, 1}},
                       {{9, 7, 5}},
                       {{33, 65, 17}},
                       {{67, 9, 73}},
                       {{129, 35, 3}},
                       {{71, 66, 33}},
                       {{1, 1, 4099}},
                       {{200, 3, 3}},
                       {{65, 67, 21}, {0.5, 0.5, 2}},
                       {{65, 9, 67}, {0.5, 3, 0.5}},
                       {{35, 41, 33}, {4, 1, 4}}};

const AxisOrder kOrders[] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

template <class T>
std::vector<T> noise(const Size3& size, std::mt19937_64& random, std::uint64_t range) {
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (T& voxel : voxels) voxel = static_cast<T>(random() % range);
  return voxels;
}

/// Deviations of the samples of all levels but the first; of cells whole and at the border.
struct Judged {
  std::vector<Deviations> whole{kMaxLevels};
  std::vector<Deviations> border{kMaxLevels};
};

template <class T>
void judge(const BrickCodec& codec, const Case& of, const std::vector<T>& voxels, Judged& judged) {
  const Levels levels(of.size, choose_halvings(of.size, of.spacing));
  const auto samples = decoded_levels(codec, levels, voxels);
  ASSERT_EQ(samples[0], voxels);
  Sums exact{of.size, {voxels.begin(), voxels.end()}, std::vector<double>(voxels.size(), 1.0)};
  double full = 1;
  for (int level = 1; level < levels.count(); ++level) {
    exact = sums_below(exact, levels.halving(level - 1));
    full *= 1 << std::popcount(levels.halving(level - 1));
    const auto& found = samples[static_cast<std::size_t>(level)];
    Deviations& whole = judged.whole[static_cast<std::size_t>(level)];
    Deviations& border = judged.border[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < found.size(); ++i) {
      const bool is_whole = exact.count[i] == full;
      const double deviation = found[i] - exact.mean(i);
      ASSERT_LE(std::abs(deviation), is_whole ? 1.5 : 2.0)
          << of.size.x << "x" << of.size.y << "x" << of.size.z << " level " << level << " sample "
          << i << ": " << +found[i] << ", mean " << exact.mean(i);
      (is_whole ? whole : border).add(deviation);
    }
  }
}

std::unique_ptr<BrickCodec> codec_for(VoxelType type, Preset preset, const AxisOrder& order) {
  CodecSettings settings;
  settings.preset = preset;
  settings.axis_order = order;
  return train_grey_model(type, {}, settings);
}

TEST(TrueMeans, ALastVoxelAloneWeighsAsOne) {
  const Levels levels({3, 1, 1}, choose_halvings({3, 1, 1}, {1, 1, 1}));
  const auto codec = codec_for(VoxelType::int16, Preset::small, kStraightOrder);
  const auto samples = decoded_levels<std::int16_t>(*codec, levels, {0, 0, 300});
  EXPECT_EQ(samples[1], (std::vector<std::int16_t>{0, 300}));
  EXPECT_EQ(samples[2], std::vector<std::int16_t>{100});
}

template <class T>
void expect_true_means(Preset preset, std::uint64_t range, Judged& judged) {
  std::mt19937_64 random(range);
  // Each order meets half of the cases, which are others for the next one.
  std::size_t turn = 0;
  for (const AxisOrder& order : kOrders) {
    const auto codec = codec_for(voxel_type_of<T>(), preset, order);
    for (const Case& one : kCases) {
      if (++turn % 2 == 0) judge(*codec, one, noise<T>(one.size, random, range), judged);
    }
    ++turn;
  }
}

TEST(TrueMeans, EverySampleIsTheMeanOfTheVoxelsInside) {
  for (const Preset preset : {Preset::small, Preset::fast}) {
    Judged judged;
    expect_true_means<std::uint8_t>(preset, 200, judged);
    expect_true_means<std::int16_t>(preset, 9, judged);
    expect_true_means<std::uint16_t>(preset, 65536, judged);
    expect_true_means<std::int32_t>(preset, 100'000'000, judged);
    for (std::size_t level = 1; level < kMaxLevels; ++level) {
      const Deviations& whole = judged.whole[level];
      const Deviations& border = judged.border[level];
      EXPECT_LE(std::abs(whole.bias()), 0.25 + whole.chance()) << "level " << level;
      EXPECT_LE(std::abs(border.bias()), 0.25 + border.chance()) << "level " << level;
    }
  }
}

}  // namespace
}  // namespace octavo
