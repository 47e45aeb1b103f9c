#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/grey/grey_codec.h"
#include "octavo/codec/grey/grey_portable.h"
#include "octavo/codec/grey/octant_transform.h"
#include "support/coded_brick.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

using testing::decoded_parent;
using testing::shape_of;
using testing::spans_of;
using testing::view_of;

enum class Content { smooth, noise, sparse, checkerboard, ramp, two_values };

/// A brick of voxels over the full range of their type where the content allows.
template <class T>
std::vector<T> make_voxels(const Size3& size, Content content, std::uint32_t seed) {
  std::mt19937_64 random(seed);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()));
  const double low = static_cast<double>(std::numeric_limits<T>::lowest());
  const double high = static_cast<double>(std::numeric_limits<T>::max());
  std::size_t i = 0;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x, ++i) {
        const double wave =
            std::sin(0.11 * static_cast<double>(x)) * std::cos(0.07 * static_cast<double>(y)) +
            std::sin(0.05 * static_cast<double>(z));
        switch (content) {
          case Content::smooth:
            voxels[i] = static_cast<T>((low + high) / 2 + (high - low) / 8 * wave +
                                       static_cast<double>(random() % 9));
            break;
          case Content::noise: voxels[i] = static_cast<T>(random()); break;
          case Content::sparse: voxels[i] = wave > 1 ? static_cast<T>(random() % 100) : T{0}; break;
          case Content::checkerboard:
            voxels[i] =
                (x + y + z) % 2 ? std::numeric_limits<T>::max() : std::numeric_limits<T>::lowest();
            break;
          case Content::ramp: voxels[i] = static_cast<T>(x + 3 * y + 7 * z); break;
          case Content::two_values: voxels[i] = wave > 0.3 ? T{100} : T{3}; break;
        }
      }
    }
  }
  return voxels;
}

/// The reference pyramid: level `level` of a brick by plain means, of the codes of its lattice.
template <class T>
std::vector<T> reference_level(const std::vector<T>& voxels, const BrickShape& shape, int level,
                               const AxisOrder& order, const grey::CodeScale& scale = {}) {
  std::vector<std::int64_t> samples;
  for (const T voxel : voxels) samples.push_back(scale.code_of(voxel));
  for (int i = 0; i < level; ++i) {
    samples = coarser_level(samples, shape, i, order);
  }
  std::vector<T> values;
  for (const std::int64_t sample : samples) {
    values.push_back(static_cast<T>(scale.voxel_of(sample)));
  }
  return values;
}

template <class T>
void expect_every_level(const BrickCodec& codec, const BrickShape& shape,
                        const std::vector<T>& voxels) {
  const EncodedBrick encoded = codec.encode(shape, view_of(voxels, shape.size[0]));
  // Bricks off the lattice of their model are coded as they are.
  grey::CodeScale lattice =
      dynamic_cast<const grey::GreyCodec&>(codec).parameters().value_map.lattice;
  for (const T voxel : voxels) {
    if (lattice.voxel_of(lattice.code_of(voxel)) != std::int64_t{voxel}) lattice = {};
  }
  ASSERT_EQ(encoded.segments.size(), static_cast<std::size_t>(shape.level_count));
  for (int level = 0; level < shape.level_count; ++level) {
    const auto count =
        static_cast<std::size_t>(shape.size[static_cast<std::size_t>(level)].voxel_count());
    std::vector<T> decoded(count);
    codec.decode(shape, voxel_type_of<T>(), encoded.range, spans_of(encoded), level,
                 decoded.data());
    ASSERT_EQ(decoded, reference_level(voxels, shape, level, codec.axis_order(), lattice))
        << "level " << level;
  }
  ASSERT_EQ(decoded_parent(codec, shape, voxel_type_of<T>(), encoded), encoded.parent);
}

constexpr Content kContents[] = {Content::smooth, Content::noise,        Content::sparse,
                                 Content::ramp,   Content::checkerboard, Content::two_values};
const Size3 kSizes[] = {{64, 64, 64}, {1, 1, 1}, {1, 1, 2}, {3, 1, 1},    {2, 2, 2},
                        {64, 1, 1},   {1, 37, 1}, {5, 7, 3}, {17, 64, 31}, {63, 2, 64}};

template <class T>
class GreyCodecOfType : public ::testing::Test {};
using IntegerTypes = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
                                    std::int32_t, std::uint32_t>;
TYPED_TEST_SUITE(GreyCodecOfType, IntegerTypes);

/// Large bricks take nearly all of the time: in the everyday run each type and turn meets them with
/// one content, which is another for its neighbors.
template <class T>
bool is_left_out(Content content, const Size3& size, std::size_t turn) {
  const auto type = static_cast<std::size_t>(voxel_type_of<T>());
  return size.voxel_count() > 36000 && !octavo::testing::is_full_form() &&
         content != kContents[(type + turn) % std::size(kContents)];
}

/// Models of every content and size, as they come out of a file, give every level back.
template <class T>
void expect_lossless(Preset preset) {
  for (const Content content : kContents) {
    for (const Size3& size : kSizes) {
      if (is_left_out<T>(content, size, static_cast<std::size_t>(preset))) continue;
      SCOPED_TRACE(::testing::Message() << "content " << static_cast<int>(content) << " size "
                                      << size.x << "x" << size.y << "x" << size.z);
      const auto voxels = make_voxels<T>(size, content, 5);
      const BrickShape shape = shape_of(size);
      const TrainingBrick training{shape, view_of(voxels, size)};
      const auto trained =
          train_grey_model(voxel_type_of<T>(), std::span(&training, 1), {preset, 0});
      expect_every_level(*trained, shape, voxels);
      expect_every_level(*parse_grey_model(voxel_type_of<T>(), trained->serialized()), shape,
                         voxels);
    }
  }
}

TYPED_TEST(GreyCodecOfType, EveryLevelEqualsTheReferencePyramid) {
  expect_lossless<TypeParam>(Preset::small);
}

TYPED_TEST(GreyCodecOfType, TheFastPresetIsLosslessAtEveryLevelToo) {
  expect_lossless<TypeParam>(Preset::fast);
}

/// Encodes with a maximum error and looks at every voxel.
template <class T>
void expect_within(const BrickCodec& codec, const BrickShape& shape, const std::vector<T>& voxels,
                   std::int64_t max_error) {
  const EncodedBrick encoded = codec.encode(shape, view_of(voxels, shape.size[0]));
  std::vector<T> decoded(voxels.size());
  codec.decode(shape, voxel_type_of<T>(), encoded.range, spans_of(encoded), 0, decoded.data());
  std::int64_t largest = 0;
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const auto voxel = static_cast<std::int64_t>(decoded[i]);
    largest = std::max(largest, std::abs(voxel - static_cast<std::int64_t>(voxels[i])));
    ASSERT_GE(voxel, encoded.range.min);
    ASSERT_LE(voxel, encoded.range.max);
  }
  ASSERT_LE(largest, max_error);
  ASSERT_EQ(largest, encoded.max_error);
  ASSERT_EQ(decoded_parent(codec, shape, voxel_type_of<T>(), encoded), encoded.parent);
}

TYPED_TEST(GreyCodecOfType, EveryVoxelStaysWithinTheMaximumError) {
  using T = TypeParam;
  const Size3 sizes[] = {{40, 33, 29}, {1, 1, 1}, {1, 1, 2}, {5, 7, 3}};
  const std::int64_t errors[] = {1, 40, std::int64_t{1} << 30};
  std::size_t turn = 0;
  for (const Preset preset : {Preset::small, Preset::fast}) {
    for (const std::int64_t max_error : errors) {
      ++turn;
      for (const Content content : kContents) {
        for (const Size3& size : sizes) {
          if (is_left_out<T>(content, size, turn)) continue;
          SCOPED_TRACE(::testing::Message() << "error " << max_error << " content "
                                          << static_cast<int>(content) << " x " << size.x);
          const auto voxels = make_voxels<T>(size, content, 8);
          const BrickShape shape = shape_of(size);
          const TrainingBrick training{shape, view_of(voxels, size)};
          const auto trained =
              train_grey_model(voxel_type_of<T>(), std::span(&training, 1), {preset, max_error});
          const auto codec = parse_grey_model(voxel_type_of<T>(), trained->serialized());
          ASSERT_EQ(codec->serialized(), trained->serialized());
          expect_within(*codec, shape, voxels, max_error);
          // What it was not trained on keeps to it as well.
          expect_within(*codec, shape, make_voxels<T>(size, Content::noise, 4), max_error);
          expect_within(*codec, shape, make_voxels<T>(size, Content::checkerboard, 4), max_error);
        }
      }
    }
  }
}

TYPED_TEST(GreyCodecOfType, AModelTrainedElsewhereIsLosslessToo) {
  using T = TypeParam;
  const Size3 size{32, 48, 64};
  const BrickShape shape = shape_of(size);
  const auto quiet = make_voxels<T>(size, Content::two_values, 1);
  const TrainingBrick training{shape, view_of(quiet, size)};
  const auto trained = train_grey_model(voxel_type_of<T>(), std::span(&training, 1));
  const auto codec = parse_grey_model(voxel_type_of<T>(), trained->serialized());
  for (const Content content : kContents) {
    expect_every_level(*codec, shape, make_voxels<T>(size, content, 9));
  }
}

TEST(GreyCodec, ThickSlicesHalveTheirAxisLater) {
  const Size3 size{64, 64, 16};
  const BrickShape shape = shape_of(size, {1, 1, 4});
  EXPECT_EQ(shape.halving[0], 3);
  const auto voxels = make_voxels<std::int16_t>(size, Content::smooth, 2);
  const TrainingBrick training{shape, view_of(voxels, size)};
  const auto codec = train_grey_model(VoxelType::int16, std::span(&training, 1));
  expect_every_level(*codec, shape, voxels);
}

TEST(GreyCodec, AnUntrainedModelIsLossless) {
  const auto codec = train_grey_model(VoxelType::int16, {});
  const Size3 size{20, 30, 40};
  expect_every_level(*codec, shape_of(size), make_voxels<std::int16_t>(size, Content::smooth, 3));
}

TEST(GreyCodec, UniformBricksTakeNoBytes) {
  const auto codec = train_grey_model(VoxelType::int16, {});
  const Size3 size{64, 64, 64};
  const std::vector<std::int16_t> voxels(64 * 64 * 64, -1024);
  const EncodedBrick encoded = codec->encode(shape_of(size), view_of(voxels, size));
  EXPECT_EQ(encoded.range, (ValueRange{-1024, -1024}));
  EXPECT_EQ(encoded.parent, -1024);
  for (const Bytes& segment : encoded.segments) EXPECT_TRUE(segment.empty());
}

TEST(GreyCodec, NoiseIsStoredWithoutGrowth) {
  const Size3 size{64, 64, 64};
  const auto voxels = make_voxels<std::uint16_t>(size, Content::noise, 4);
  const TrainingBrick training{shape_of(size), view_of(voxels, size)};
  const auto codec = train_grey_model(VoxelType::uint16, std::span(&training, 1));
  const EncodedBrick encoded = codec->encode(shape_of(size), view_of(voxels, size));
  std::size_t bytes = 0;
  for (const Bytes& segment : encoded.segments) bytes += segment.size();
  EXPECT_LE(bytes, voxels.size() * 2);
}

TEST(GreyCodec, ParentIsTheNextSampleOfThePyramid) {
  const Size3 size{64, 64, 64};
  BrickShape shape = shape_of({128, 64, 64});
  ASSERT_EQ(shape.level_count, 6);
  const auto voxels = make_voxels<std::int16_t>(size, Content::smooth, 8);
  const auto codec = train_grey_model(VoxelType::int16, {});
  const EncodedBrick encoded = codec->encode(shape, view_of(voxels, size));
  const AxisOrder order = codec->axis_order();
  auto top = reference_level(voxels, shape, 5, order);
  std::vector<std::int64_t> samples(top.begin(), top.end());
  EXPECT_EQ(encoded.parent, coarser_level(samples, shape, 5, order).front());
}

/// Values that lie 16 apart are coded as multiples: so are the means.
TEST(GreyCodec, MeansOfValuesOnALatticeStayOnIt) {
  const Size3 size{40, 33, 29};
  const BrickShape shape = shape_of(size);
  const auto multiples = make_voxels<std::uint8_t>(size, Content::smooth, 6);
  std::vector<std::uint16_t> voxels;
  for (const std::uint8_t value : multiples)
    voxels.push_back(static_cast<std::uint16_t>(16 * value + 5));
  const TrainingBrick training{shape, view_of(voxels, size)};
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto trained = train_grey_model(VoxelType::uint16, std::span(&training, 1), {preset, 0});
    const auto codec = parse_grey_model(VoxelType::uint16, trained->serialized());
    const EncodedBrick encoded = codec->encode(shape, view_of(voxels, size));
    for (int level = 0; level < shape.level_count; ++level) {
      auto expected = reference_level(multiples, shape, level, codec->axis_order());
      std::vector<std::uint16_t> decoded(expected.size());
      codec->decode(shape, VoxelType::uint16, encoded.range, spans_of(encoded), level,
                    decoded.data());
      for (std::size_t i = 0; i < decoded.size(); ++i) ASSERT_EQ(decoded[i], 16 * expected[i] + 5);
    }
    // Voxels beside the lattice keep the means they have.
    expect_every_level(*codec, shape, make_voxels<std::uint16_t>(size, Content::smooth, 7));
    expect_every_level(*codec, shape, make_voxels<std::uint16_t>(size, Content::noise, 7));
  }
}

/// A scan of few values, spread over 8 bits: unused ones cost nothing, and means stay means.
std::vector<std::uint8_t> spread_values(const Size3& size, unsigned seed) {
  auto voxels = make_voxels<std::uint8_t>(size, Content::smooth, seed);
  for (auto& voxel : voxels) voxel = static_cast<std::uint8_t>(voxel * 100 / 255 * 255 / 100);
  return voxels;
}

TEST(GreyCodec, ValuesThatDoNotOccurCostNothing) {
  for (const Size3& size : {Size3{64, 48, 40}, Size3{41, 33, 29}}) {
    const BrickShape shape = shape_of(size);
    const auto voxels = spread_values(size, 6);
    const TrainingBrick training{shape, view_of(voxels, size)};
    const auto trained = train_grey_model(VoxelType::uint8, std::span(&training, 1));
    const auto codec = parse_grey_model(VoxelType::uint8, trained->serialized());
    ASSERT_EQ(codec->serialized(), trained->serialized());
    expect_every_level(*codec, shape, voxels);
    expect_every_level(*codec, shape, make_voxels<std::uint8_t>(size, Content::sparse, 7));
    const auto bytes_of = [&](const std::vector<std::uint8_t>& brick) {
      std::size_t bytes = 0;
      for (const Bytes& s : codec->encode(shape, view_of(brick, size)).segments) bytes += s.size();
      return bytes;
    };
    // Means take values that do not occur: only voxels have gaps.
    const EncodedBrick brick = codec->encode(shape, view_of(voxels, size));
    BrickShape of_means = shape;
    of_means.first_level = 6;
    std::vector<std::uint8_t> out(voxels.size());
    const auto spans = spans_of(brick);
    EXPECT_THROW(codec->decode(of_means, VoxelType::uint8, brick.range, spans, 0, out.data()),
                 Error);
    auto other = voxels;
    // A few values that the model does not know are listed with the brick.
    other[0] = 1;
    other[97] = 81;
    expect_every_level(*codec, shape, other);
    EXPECT_LT(bytes_of(other), bytes_of(voxels) * 105 / 100);
    // More of them are not.
    for (std::size_t i = 0; i < 200; ++i) other[97 * i] = static_cast<std::uint8_t>(i + 1);
    expect_every_level(*codec, shape, other);
    EXPECT_GT(bytes_of(other), bytes_of(voxels) * 110 / 100);
  }
}

/// Damage gives an error or other voxels, never anything worse (run under sanitizers as well).
/// Few voxels of any value on a ground of 3.
template <class T>
std::vector<T> speckles(const Size3& size) {
  std::mt19937 random(9);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()), T{3});
  for (T& voxel : voxels) {
    if (random() % 50 == 0) voxel = static_cast<T>(random() & std::numeric_limits<T>::max());
  }
  return voxels;
}

TEST(GreyCodec, EdgesOfTheBackgroundAreToldApart) {
  const Size3 size{41, 33, 29};
  const BrickShape shape = shape_of(size);
  const auto voxels = speckles<std::uint16_t>(size);
  const TrainingBrick training{shape, view_of(voxels, size)};
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto trained = train_grey_model(VoxelType::uint16, std::span(&training, 1), {preset, 0});
    const Bytes model = trained->serialized();
    EXPECT_NE(model[0] & 64, 0) << "the model does not tell edges apart";
    const auto codec = parse_grey_model(VoxelType::uint16, model);
    expect_every_level(*codec, shape, voxels);
    expect_every_level(*codec, shape, make_voxels<std::uint16_t>(size, Content::smooth, 7));
    // A pair and nothing else: no background beside it tells of the edge.
    expect_every_level(*codec, shape_of({2, 1, 1}), std::vector<std::uint16_t>{7, 900});

    EncodedBrick other = codec->encode(shape, view_of(voxels, size));
    // A state that starts elsewhere does not end where it should.
    other.segments[0].back() = static_cast<std::uint8_t>(other.segments[0].back() ^ 1);
    std::vector<std::uint16_t> out(voxels.size());
    EXPECT_THROW(
        codec->decode(shape, VoxelType::uint16, other.range, spans_of(other), 0, out.data()),
        Error);
  }
}

template <class T>
void expect_contained(const BrickShape& shape, const std::vector<T>& voxels, std::mt19937& random) {
  const TrainingBrick training{shape, view_of(voxels, shape.size[0])};
  const auto codec = train_grey_model(voxel_type_of<T>(), std::span(&training, 1));
  const EncodedBrick good = codec->encode(shape, training.view);
  std::vector<T> out(voxels.size());
  for (int round = 0; round < 300; ++round) {
    EncodedBrick bad = good;
    for (int hits = 0; hits < 3; ++hits) {
      Bytes& segment = bad.segments[random() % bad.segments.size()];
      if (segment.empty()) continue;
      if (random() % 4 == 0) segment.resize(random() % segment.size());
      else segment[random() % segment.size()] = static_cast<std::uint8_t>(random());
    }
    try {
      codec->decode(shape, voxel_type_of<T>(), good.range, spans_of(bad), 0, out.data());
    } catch (const Error& error) {
      // A flipped bit may be a flag that was not given out.
      EXPECT_TRUE(error.kind() == ErrorKind::corrupt ||
                  error.kind() == ErrorKind::unsupported_version);
    }
  }
}

TEST(GreyCodec, DamagedSegmentsAreContained) {
  const Size3 size{40, 33, 29};
  const BrickShape shape = shape_of(size);
  std::mt19937 random(77);
  for (const Content content : {Content::smooth, Content::sparse, Content::noise}) {
    const auto voxels = make_voxels<std::int16_t>(size, content, 6);
    expect_contained(shape, voxels, random);
  }
  expect_contained(shape, spread_values(size, 6), random);
  expect_contained(shape, speckles<std::uint8_t>(size), random);
  expect_contained(shape, speckles<std::int32_t>(size), random);
}

/// The same for 32-bit samples, with a range just above 16 bits and arbitrary bytes as segments:
/// damaged details may then leave the range and wrap.
TEST(GreyCodec, DamagedWideSegmentsAreContained) {
  std::mt19937 random(78);
  const auto codec = train_grey_model(VoxelType::int32, {});
  for (int round = 0; round < 2000; ++round) {
    const auto side = [&] { return static_cast<std::int64_t>(1 + random() % 9); };
    const Size3 size{side(), side(), side()};
    const BrickShape shape = shape_of(size);
    const auto last = static_cast<std::size_t>(shape.level_count) - 1;
    const ValueRange range{0, 0x10000 + static_cast<std::int64_t>(random() % 3)};
    EncodedBrick bad;
    bad.segments.resize(last + 1);
    for (Bytes& segment : bad.segments) {
      segment.resize(64 + random() % 2000);
      for (auto& byte : segment) byte = static_cast<std::uint8_t>(random());
      segment.front() = static_cast<std::uint8_t>(random() % 60);
    }
    // Coarsest samples at the lowest value.
    const std::int64_t bits = shape.size[last].voxel_count() * 17;
    bad.segments[last].assign(static_cast<std::size_t>((bits + 7) / 8), 0);
    std::vector<std::int32_t> out(static_cast<std::size_t>(size.voxel_count()));
    try {
      codec->decode(shape, VoxelType::int32, range, spans_of(bad), 0, out.data());
    } catch (const Error& error) {
      // A flipped bit may be a flag that was not given out.
      EXPECT_TRUE(error.kind() == ErrorKind::corrupt ||
                  error.kind() == ErrorKind::unsupported_version);
    }
  }
}

TEST(GreyCodec, AStoredBrickHasNoOtherSegments) {
  const Size3 size{8, 8, 8};
  const BrickShape shape = shape_of(size);
  const auto voxels = make_voxels<std::uint16_t>(size, Content::noise, 4);
  const auto codec = train_grey_model(VoxelType::uint16, {});
  EncodedBrick brick = codec->encode(shape, view_of(voxels, size));
  ASSERT_TRUE(brick.segments.back().empty());
  brick.segments[1] = {1, 2, 3};
  std::vector<std::uint16_t> out(voxels.size());
  EXPECT_THROW(
      codec->decode(shape, VoxelType::uint16, brick.range, spans_of(brick), 0, out.data()), Error);
}

TEST(GreyCodec, EveryTruncationOfASegmentIsNoticed) {
  const Size3 size{16, 16, 16};
  const BrickShape shape = shape_of(size);
  const auto voxels = make_voxels<std::int16_t>(size, Content::smooth, 6);
  const auto codec = train_grey_model(VoxelType::int16, {});
  const EncodedBrick good = codec->encode(shape, view_of(voxels, size));
  std::vector<std::int16_t> out(voxels.size());
  for (std::size_t i = 0; i < good.segments.size(); ++i) {
    for (std::size_t length = 0; length < good.segments[i].size(); ++length) {
      EncodedBrick bad = good;
      bad.segments[i].resize(length);
      EXPECT_THROW(codec->decode(shape, VoxelType::int16, good.range, spans_of(bad), 0, out.data()),
                   Error);
    }
  }
}

/// Random boxes of every level, into arrays larger than they are. `before` is decoded in front of
/// each, so that nothing of the brick itself is left in the thread's work space.
void expect_boxes(const BrickCodec& codec, const BrickShape& shape, const EncodedBrick& brick,
                  const EncodedBrick& before) {
  std::mt19937 random(6);
  for (int level = 0; level < shape.level_count; ++level) {
    const Size3& size = shape.size[static_cast<std::size_t>(level)];
    std::vector<std::int16_t> whole(static_cast<std::size_t>(size.voxel_count()));
    codec.decode(shape, VoxelType::int16, brick.range, spans_of(brick), level, whole.data());
    for (int i = 0; i < 6; ++i) {
      Box box;
      for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = static_cast<std::int64_t>(random()) % size[axis];
        const std::int64_t left = size[axis] - box.lo[axis];
        box.hi[axis] = box.lo[axis] + 1 + static_cast<std::int64_t>(random()) % left;
      }
      const Size3 own = box.size();
      const std::int64_t row = own.x + 3;
      const std::int64_t plane = row * (own.y + 1);
      constexpr std::int16_t kUntouched = 0x5a5a;
      std::vector<std::int16_t> found(static_cast<std::size_t>(plane * own.z), kUntouched);
      std::vector<std::int16_t> expected = found;
      for (std::int64_t z = 0; z < own.z; ++z) {
        for (std::int64_t y = 0; y < own.y; ++y) {
          const std::int64_t from =
              ((z + box.lo.z) * size.y + y + box.lo.y) * size.x + box.lo.x;
          std::copy_n(whole.begin() + from, own.x, expected.begin() + z * plane + y * row);
        }
      }
      std::vector<std::int16_t> others(static_cast<std::size_t>(shape.size[0].voxel_count()));
      codec.decode(shape, VoxelType::int16, before.range, spans_of(before), 0, others.data());
      codec.decode_box(shape, VoxelType::int16, brick.range, spans_of(brick),
                       {level, box, {found.data(), row, plane}});
      ASSERT_EQ(found, expected) << "level " << level << " box " << i;
    }
  }
}

/// Whole bricks and such that have parts, stored and uniform ones.
void expect_boxes_of(const Size3& size, const CodecSettings& settings, Content content) {
  const BrickShape shape = shape_of(size);
  const auto voxels = make_voxels<std::int16_t>(size, content, 5);
  const TrainingBrick sample{shape, view_of(voxels, size)};
  const auto codec = train_grey_model(VoxelType::int16, {&sample, 1}, settings);
  std::vector<std::int16_t> others(voxels.rbegin(), voxels.rend());
  for (std::size_t i = 0; i < others.size(); i += 5) others[i] = static_cast<std::int16_t>(i % 700);
  const EncodedBrick other = codec->encode(shape, view_of(others, size));
  expect_boxes(*codec, shape, codec->encode(shape, sample.view), other);
  const std::vector<std::int16_t> even(voxels.size(), 12);
  expect_boxes(*codec, shape, codec->encode(shape, view_of(even, size)), other);
}

TEST(GreyCodec, EveryBoxOfEveryLevelIsThatOfTheLevel) {
  const AxisOrder turned{2, 0, 1};
  const CodecSettings some_settings[] = {
      {.preset = Preset::small, .axis_order = kStraightOrder},
      {.preset = Preset::small, .axis_order = turned, .access = Access::boxes},
      {.preset = Preset::small, .max_error = 5, .axis_order = turned},
      {.preset = Preset::fast, .axis_order = turned, .access = Access::none},
      {.preset = Preset::fast, .axis_order = kStraightOrder, .access = Access::slices},
      {.preset = Preset::fast, .max_error = 5, .access = Access::boxes}};
  for (const CodecSettings& settings : some_settings) {
    for (const Content content : {Content::smooth, Content::sparse, Content::noise}) {
      for (const Size3& size : {Size3{40, 64, 33}, Size3{20, 20, 20}, Size3{7, 19, 21}}) {
        SCOPED_TRACE(::testing::Message() << "settings " << &settings - some_settings
                                          << " content " << static_cast<int>(content) << " z "
                                          << size.z);
        expect_boxes_of(size, settings, content);
      }
    }
  }
}

}  // namespace
}  // namespace octavo
