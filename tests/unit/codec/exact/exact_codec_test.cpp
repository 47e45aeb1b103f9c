#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <utility>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/exact/absent_samples.h"
#include "octavo/codec/exact/float_bins.h"
#include "octavo/codec/grey/octant_transform.h"
#include "octavo/core/error.h"
#include "support/coded_brick.h"
#include "support/exact_codings.h"

namespace octavo {
namespace {

using testing::exact_coding;
using testing::kExactCodings;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kLargest = std::numeric_limits<float>::max();

float of_bits(std::uint32_t bits) { return std::bit_cast<float>(bits); }
std::uint32_t bits_of(float value) { return std::bit_cast<std::uint32_t>(value); }

/// What a brick may hold.
enum class Floats {
  noise, smooth, wide_range, denormals, constant, two_values, multiples, zeros_and_few, halves,
  sparse_nan, nan_outside, payloads, infinities, all_nan, signed_zeros, beyond_all_codes, any_bits
};
constexpr Floats kAllFloats[] = {
    Floats::noise,       Floats::smooth,        Floats::wide_range,   Floats::denormals,
    Floats::constant,    Floats::two_values,    Floats::multiples,    Floats::zeros_and_few,
    Floats::halves,      Floats::sparse_nan,    Floats::nan_outside,  Floats::payloads,
    Floats::infinities,  Floats::all_nan,       Floats::signed_zeros, Floats::beyond_all_codes,
    Floats::any_bits};

float float_at(Floats sort, const Index3& p, std::mt19937& random) {
  const auto at = static_cast<double>(p.x) * 0.11 + static_cast<double>(p.y) * 0.07;
  const double wave = std::sin(at) * std::cos(0.05 * static_cast<double>(p.z));
  std::normal_distribution<double> normal(0, 1);
  const double noise = normal(random);
  const auto some = static_cast<std::uint32_t>(random());
  switch (sort) {
    case Floats::noise: return static_cast<float>(100 * wave + noise);
    case Floats::smooth: return static_cast<float>(wave);
    case Floats::wide_range: return static_cast<float>(std::pow(10.0, 30 * wave) * noise);
    case Floats::denormals: return static_cast<float>(noise * 1e-40);
    case Floats::constant: return 0.3f;
    case Floats::two_values: return wave > 0.2 ? 0.7f : -1e-3f;
    case Floats::multiples: return static_cast<float>(std::floor(90 * wave) * 0.1);
    case Floats::zeros_and_few: return wave > 0.5 ? static_cast<float>(noise * 1e-9) : 0.0f;
    case Floats::halves: return of_bits(bits_of(static_cast<float>(noise)) & ~0x1fffu);
    case Floats::sparse_nan: return some % 50 == 0 ? kNan : static_cast<float>(wave + noise);
    case Floats::nan_outside: return wave < 0.1 ? kNan : static_cast<float>(9 * wave + noise);
    case Floats::payloads: return some % 3 == 0 ? of_bits(0xff800001u + some % 9) : 1.5f;
    case Floats::infinities:
      return some % 7 == 0 ? kInfinity : some % 11 == 0 ? -kInfinity : static_cast<float>(noise);
    case Floats::all_nan: return kNan;
    case Floats::signed_zeros: return some % 3 == 0 ? -0.0f : some % 5 == 0 ? 1.0f : 0.0f;
    case Floats::beyond_all_codes:
      return some % 2 == 0 ? kLargest : static_cast<float>(-1e38 * noise);
    case Floats::any_bits: return of_bits(some);
  }
  return 0;
}

struct Brick {
  BrickShape shape;
  std::vector<float> voxels;

  Brick(Floats sort, const Size3& size, int tier = 0) {
    const Levels levels(size, choose_halvings(size, {1, 1, 1}));
    shape = brick_shape(levels, 0, {0, 0, 0});
    shape.first_level = 6 * tier;
    std::mt19937 random(7);
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          voxels.push_back(float_at(sort, {x, y, z}, random));
        }
      }
    }
  }
  BrickView view() const {
    const Size3& size = shape.size[0];
    return {voxels.data(), VoxelType::float32, size, size.x, size.x * size.y};
  }
};

std::vector<float> decoded(const BrickCodec& codec, const Brick& brick, const EncodedBrick& encoded,
                           int level) {
  const Size3& size = brick.shape.size[static_cast<std::size_t>(level)];
  std::vector<float> samples(static_cast<std::size_t>(size.voxel_count()));
  std::vector<ByteSpan> segments(encoded.segments.begin(), encoded.segments.end());
  const bool is_stored = segments.back().empty();
  for (int i = 0; i < level && !is_stored; ++i) segments[static_cast<std::size_t>(i)] = {};
  codec.decode(brick.shape, VoxelType::float32, encoded.range, segments, level, samples.data());
  return samples;
}

bool are_same(const std::vector<float>& a, const std::vector<float>& b) {
  return std::ranges::equal(a, b, {}, bits_of, bits_of);
}

std::unique_ptr<BrickCodec> trained_on(const Brick& brick, const SampleCoding& coding,
                                       Preset preset = Preset::small) {
  const TrainingBrick training{brick.shape, brick.view()};
  return train_exact_model({&training, 1}, {preset, 0}, coding);
}

const Size3 kSizes[] = {{33, 20, 17}, {1, 1, 1}, {1, 1, 2}, {5, 7, 3}, {2, 2, 2}, {40, 3, 9}};

TEST(ExactCodec, EveryBitOfEveryKindOfFloatComesBack) {
  for (const Floats sort : kAllFloats) {
    for (const Size3& size : kSizes) {
      const Brick brick(sort, size);
      for (const SampleCoding& coding : kExactCodings) {
        // The large ones meet each coding with some of the contents.
        const auto turn = static_cast<std::size_t>(&coding - kExactCodings);
        const bool is_large = size.voxel_count() > 4096;
        if (is_large && (static_cast<std::size_t>(sort) + turn) % 3 != 0) continue;
        SCOPED_TRACE(::testing::Message() << "floats " << static_cast<int>(sort) << ", " << size.x
                                          << " x " << size.y << " x " << size.z << ", scale "
                                          << coding.scale);
        const auto trained = trained_on(brick, coding, Preset::fast);
        const auto codec =
            parse_model(VolumeKind::grey, VoxelType::int32, coding, trained->serialized());
        const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
        ASSERT_TRUE(are_same(decoded(*codec, brick, encoded, 0), brick.voxels));
        ASSERT_EQ(
            testing::decoded_parent(*codec, brick.shape, VoxelType::float32, encoded),
            encoded.parent);
      }
    }
  }
}

TEST(ExactCodec, AFullBrickComesBackWithBothPresets) {
  const std::pair<Preset, Floats> cases[] = {{Preset::small, Floats::nan_outside},
                                             {Preset::fast, Floats::any_bits}};
  for (const auto& [preset, sort] : cases) {
    const Brick brick(sort, {64, 64, 64});
    const auto codec = trained_on(brick, exact_coding(0.125), preset);
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    EXPECT_TRUE(are_same(decoded(*codec, brick, encoded, 0), brick.voxels));
  }
}

TEST(ExactCodec, TheRangeBoundsAllFiniteVoxels) {
  for (const Floats sort : kAllFloats) {
    const Brick brick(sort, {20, 17, 9});
    for (const SampleCoding& coding : kExactCodings) {
      const EncodedBrick encoded =
          trained_on(brick, coding, Preset::fast)->encode(brick.shape, brick.view());
      for (const float v : brick.voxels) {
        if (!std::isfinite(v)) continue;
        ASSERT_LE(coding.voxel_of(encoded.range.min), v) << static_cast<int>(sort);
        ASSERT_GE(coding.voxel_of(encoded.range.max), v) << static_cast<int>(sort);
      }
    }
  }
}

TEST(ExactCodec, ABrickIsUniformWhereAllVoxelsAreThatOfOneCode) {
  const Size3 size{9, 8, 7};
  const auto is_uniform = [&](float voxel) {
    Brick brick(Floats::constant, size);
    std::ranges::fill(brick.voxels, voxel);
    const auto codec = trained_on(brick, exact_coding(0.5));
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    return encoded.range.min == encoded.range.max;
  };
  EXPECT_TRUE(is_uniform(0));
  EXPECT_TRUE(is_uniform(-3.5f));
  EXPECT_FALSE(is_uniform(-0.0f));
  EXPECT_FALSE(is_uniform(0.3f));
  EXPECT_FALSE(is_uniform(kNan));
}

/// The levels of a brick by the definition: codes by plain means, where nothing is absent.
TEST(ExactCodec, CoarseLevelsAreTheMeansOfTheCodes) {
  for (const Floats sort : {Floats::noise, Floats::multiples, Floats::two_values, Floats::smooth}) {
    const Brick brick(sort, {33, 20, 17});
    const SampleCoding coding = exact_coding(0.125);
    const auto codec = trained_on(brick, coding);
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    const exact::FloatBins bins(coding);
    std::vector<std::int64_t> means;
    for (const float v : brick.voxels) means.push_back(bins.code_of(v));
    for (int level = 1; level < brick.shape.level_count; ++level) {
      means = coarser_level(means, brick.shape, level - 1, codec->axis_order());
      const std::vector<float> samples = decoded(*codec, brick, encoded, level);
      ASSERT_EQ(samples.size(), means.size());
      for (std::size_t i = 0; i < means.size(); ++i) {
        ASSERT_EQ(samples[i], coding.voxel_of(means[i])) << "level " << level;
      }
    }
  }
}

/// With the mean, of each level, of the samples below that are no NaN.
TEST(ExactCodec, CoarseLevelsLeaveOutWhatIsNotFinite) {
  for (const Floats sort : {Floats::sparse_nan, Floats::nan_outside, Floats::infinities}) {
    const Brick brick(sort, {32, 16, 8});
    const double step = 1.0 / 1024;
    const auto codec = trained_on(brick, exact_coding(step));
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    std::vector<float> fine = brick.voxels;
    for (int level = 1; level < brick.shape.level_count; ++level) {
      const auto slot = static_cast<std::size_t>(level);
      const Size3& size = brick.shape.size[slot];
      const Size3& below = brick.shape.size[slot - 1];
      const HalvingMask mask = brick.shape.halving[slot - 1];
      const std::vector<float> coarse = decoded(*codec, brick, encoded, level);
      std::vector<double> sums(coarse.size());
      std::vector<double> counts(coarse.size());
      for (std::int64_t i = 0; i < below.voxel_count(); ++i) {
        const float v = fine[static_cast<std::size_t>(i)];
        if (!std::isfinite(v)) continue;
        const std::int64_t x = i % below.x >> (mask & 1);
        const std::int64_t y = i / below.x % below.y >> (mask >> 1 & 1);
        const std::int64_t z = i / (below.x * below.y) >> (mask >> 2 & 1);
        const auto at = static_cast<std::size_t>((z * size.y + y) * size.x + x);
        sums[at] += static_cast<double>(v);
        ++counts[at];
      }
      for (std::size_t i = 0; i < coarse.size(); ++i) {
        ASSERT_EQ(std::isnan(coarse[i]), counts[i] == 0);
        if (counts[i] == 0) continue;
        // Half a step of the code and half a step for each of three splits.
        ASSERT_NEAR(static_cast<double>(coarse[i]), sums[i] / counts[i], 2.1 * step);
      }
      fine = coarse;
    }
  }
}

TEST(ExactCodec, TheParentIsTheSampleAboveAndNanWhereAllIs) {
  const Brick nan(Floats::all_nan, {8, 8, 8});
  const auto parent = [](const Brick& brick) {
    const auto codec = trained_on(brick, exact_coding(0.25));
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    return of_bits(static_cast<std::uint32_t>(encoded.parent));
  };
  EXPECT_EQ(bits_of(parent(nan)), exact::kUsualNan);
  Brick some = nan;
  some.voxels[77] = 4.25f;
  EXPECT_EQ(parent(some), 4.25f);
}

TEST(ExactCodec, CoarseTiersKeepTheFloatsThatBricksBelowDetermine) {
  const SampleCoding coding = exact_coding(0.125);
  Brick brick(Floats::nan_outside, {21, 9, 14}, 1);
  for (float& v : brick.voxels) v = std::isnan(v) ? kNan : std::round(v * 8) / 8;
  const auto codec = trained_on(brick, coding);
  const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
  EXPECT_TRUE(are_same(decoded(*codec, brick, encoded, 0), brick.voxels));
}

TEST(ExactCodec, PlacesOfNoiseAreAsManyBitsAsTheBinHas) {
  // Between 512 and 1023 the bins of width 1/4 hold 2^(-2 + 14) floats each.
  Brick brick(Floats::constant, {32, 32, 32});
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(513, 1000);
  for (float& v : brick.voxels) v = uniform(random);
  const auto codec = trained_on(brick, exact_coding(0.25), Preset::fast);
  const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
  std::size_t bytes = 0;
  for (const Bytes& segment : encoded.segments) bytes += segment.size();
  const double bits = 8.0 * static_cast<double>(bytes) / static_cast<double>(brick.voxels.size());
  // log2(487 * 4) bits of a code and 12 of the place.
  EXPECT_LE(bits, 10.93 + 12 + 0.4);
}

TEST(ExactCodec, FloatsThatRepeatAreNotCodedAgain) {
  // Square roots: no multiples of one number, but few different ones.
  Brick brick(Floats::constant, {32, 32, 32});
  std::mt19937 random(3);
  for (float& v : brick.voxels) v = std::sqrt(static_cast<float>(random() % 64));
  const auto codec = trained_on(brick, exact_coding(0x1p-5), Preset::fast);
  const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
  std::size_t bytes = 0;
  for (const Bytes& segment : encoded.segments) bytes += segment.size();
  // 6 bits tell which; the grey codec takes 2 more for so even a choice. Mantissas would take 20.
  EXPECT_LE(8.0 * static_cast<double>(bytes) / static_cast<double>(brick.voxels.size()), 10);
  EXPECT_TRUE(are_same(decoded(*codec, brick, encoded, 0), brick.voxels));
}

std::size_t bytes_of(const EncodedBrick& encoded) {
  std::size_t bytes = 0;
  for (const Bytes& segment : encoded.segments) bytes += segment.size();
  return bytes;
}

TEST(ExactCodec, NoBrickTakesMoreThanItsFloatsAndAByte) {
  for (const Floats sort : kAllFloats) {
    for (const Size3& size : kSizes) {
      const Brick brick(sort, size);
      for (const double scale : {0.25, 0x1p-148, 1e30}) {
        const SampleCoding coding = exact_coding(scale);
        const auto codec = trained_on(brick, coding, Preset::fast);
        const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
        EXPECT_LE(bytes_of(encoded), 1 + 4 * brick.voxels.size())
            << "floats " << static_cast<int>(sort) << ", scale " << coding.scale;
      }
    }
  }
}

TEST(ExactCodec, OneOutlierDoesNotMakeABrickLargerThanItsFloats) {
  Brick brick(Floats::noise, {32, 32, 32});
  const auto codec = trained_on(brick, exact_coding(0.125), Preset::fast);
  brick.voxels[1234] = 1e30f;
  const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
  EXPECT_LE(bytes_of(encoded), 1 + 4 * brick.voxels.size());
  EXPECT_TRUE(are_same(decoded(*codec, brick, encoded, 0), brick.voxels));
}

constexpr std::uint8_t kPlainFlag = 16;

/// A coded brick with its voxels as they are in the place of its segments.
EncodedBrick with_plain_floats(const Brick& brick, EncodedBrick encoded) {
  const bool is_stored = encoded.segments.back().empty();
  const Bytes& first = is_stored ? encoded.segments.front() : encoded.segments.back();
  Bytes plain = {static_cast<std::uint8_t>((first.front() & 12) | kPlainFlag)};
  for (const float voxel : brick.voxels) {
    for (int shift = 0; shift < 32; shift += 8) {
      plain.push_back(static_cast<std::uint8_t>(bits_of(voxel) >> shift));
    }
  }
  for (Bytes& segment : encoded.segments) segment.clear();
  encoded.segments.front() = plain;
  return encoded;
}

TEST(ExactCodec, PlainFloatsHaveTheLevelsOfCodedOnes) {
  for (const Floats sort : {Floats::noise, Floats::smooth, Floats::sparse_nan, Floats::infinities,
                            Floats::nan_outside, Floats::all_nan, Floats::wide_range}) {
    for (const Size3& size : kSizes) {
      const Brick brick(sort, size);
      const auto codec = trained_on(brick, exact_coding(0.25), Preset::fast);
      const EncodedBrick coded = codec->encode(brick.shape, brick.view());
      if (coded.range.min == coded.range.max) continue;
      const EncodedBrick plain = with_plain_floats(brick, coded);
      for (int level = 0; level < brick.shape.level_count; ++level) {
        EXPECT_TRUE(are_same(decoded(*codec, brick, plain, level),
                             decoded(*codec, brick, coded, level)))
            << "floats " << static_cast<int>(sort) << ", level " << level;
      }
      EXPECT_EQ(testing::decoded_parent(*codec, brick.shape, VoxelType::float32, plain),
                coded.parent);
    }
  }
}

TEST(ExactCodec, PlainFloatsStandAloneAndInTheirRange) {
  const Brick brick(Floats::noise, {5, 4, 3});
  const auto codec = trained_on(brick, exact_coding(0.25));
  const EncodedBrick coded = codec->encode(brick.shape, brick.view());
  const EncodedBrick plain = with_plain_floats(brick, coded);
  const auto is_rejected = [&](auto&& change, ErrorKind kind = ErrorKind::corrupt) {
    EncodedBrick changed = plain;
    Brick other = brick;
    change(changed, other);
    for (const int level : {0, 1}) {
      try {
        decoded(*codec, other, changed, level);
        return false;
      } catch (const Error& error) {
        if (error.kind() != kind) return false;
      }
    }
    return true;
  };
  EXPECT_FALSE(is_rejected([](EncodedBrick&, Brick&) {}));
  const auto head = [](EncodedBrick& encoded) -> std::uint8_t& {
    return encoded.segments.front().front();
  };
  EXPECT_TRUE(is_rejected([&](auto& encoded, Brick&) { head(encoded) |= 1; }));
  EXPECT_TRUE(is_rejected([&](auto& encoded, Brick&) { head(encoded) |= 2; }));
  EXPECT_TRUE(is_rejected([&](auto& encoded, Brick&) { head(encoded) |= 32; },
                          ErrorKind::unsupported_version));
  EXPECT_TRUE(is_rejected([](auto& encoded, Brick&) { encoded.segments[0].pop_back(); }));
  EXPECT_TRUE(is_rejected([](auto& encoded, Brick&) { encoded.segments[0].push_back(0); }));
  EXPECT_TRUE(is_rejected([](auto& encoded, Brick&) { encoded.segments[0].resize(1); }));
  EXPECT_TRUE(is_rejected([](auto&, Brick& other) { other.shape.first_level = 6; }));
  EXPECT_TRUE(is_rejected([](auto& encoded, Brick&) { encoded.range.max -= 4; }));
  EXPECT_TRUE(is_rejected([](auto& encoded, Brick&) { encoded.range.min += 4; }));
  EXPECT_TRUE(is_rejected([&](auto& encoded, Brick&) {
    encoded.segments = coded.segments;
    encoded.segments.back().front() = kPlainFlag;
  }));
}

TEST(ExactCodec, EveryTruncationAndManyFlipsAreRejectedOrDecode) {
  for (const Floats sort : {Floats::noise, Floats::infinities, Floats::zeros_and_few,
                            Floats::two_values, Floats::any_bits}) {
    const Brick brick(sort, {9, 8, 5});
    const auto codec = trained_on(brick, exact_coding(0.25));
    const EncodedBrick encoded = codec->encode(brick.shape, brick.view());
    int rejected = 0;
    for (std::size_t level = 0; level < encoded.segments.size(); ++level) {
      for (std::size_t at = 0; at < encoded.segments[level].size(); ++at) {
        EncodedBrick cut = encoded;
        cut.segments[level].resize(at);
        EXPECT_THROW(decoded(*codec, brick, cut, 0), Error) << level << " " << at;
        for (const unsigned flip : {1u, 16u, 255u}) {
          EncodedBrick broken = encoded;
          broken.segments[level][at] ^= static_cast<std::uint8_t>(flip);
          try {
            decoded(*codec, brick, broken, 0);
          } catch (const Error& error) {
            // A flipped bit may be a flag that was not given out.
            EXPECT_TRUE(error.kind() == ErrorKind::corrupt ||
                        error.kind() == ErrorKind::unsupported_version);
            ++rejected;
          }
        }
      }
    }
    EXPECT_GT(rejected, 0);
  }
}

}  // namespace
}  // namespace octavo
