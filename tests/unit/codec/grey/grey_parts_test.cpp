#include "octavo/codec/grey/grey_parts.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <string>
#include <tuple>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_model.h"
#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "support/coded_brick.h"

namespace octavo {
namespace {

using testing::shape_of;
using testing::spans_of;
using testing::view_of;

constexpr std::uint8_t kAllCuts = 7;

/// What the streams of a part may hold.
enum class Streams { residuals, edges, gaps, cells };

template <class T>
std::vector<T> voxels_of(const Size3& size, Streams streams, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<T> voxels;
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 0; x < size.x; ++x) {
        const double wave = std::sin(0.21 * static_cast<double>(x + 2 * y)) +
                            std::cos(0.17 * static_cast<double>(z - y));
        const auto grain = static_cast<double>(random() % 5);
        double voxel = 50 + 20 * wave + grain;
        if (streams == Streams::edges) voxel = random() % 40 == 0 ? voxel : 3;
        if (streams == Streams::gaps) voxel = 3 * std::floor(voxel / 3) + (wave > 0.4 ? 1 : 0);
        if (streams == Streams::cells && (x / 9 + y / 11 + z / 13) % 2 == 0) voxel = 7;
        voxels.push_back(static_cast<T>(voxel));
      }
    }
  }
  // Every type uses all its width.
  if (sizeof(T) > 1) {
    for (std::size_t i = 0; i < voxels.size() && streams == Streams::residuals; ++i) {
      voxels[i] = static_cast<T>(voxels[i] * (std::numeric_limits<T>::max() / 128));
    }
  }
  return voxels;
}

/// A model of the straight axis order and of whole bricks.
template <class T>
Bytes trained_on(Streams streams, CodecSettings settings) {
  static std::map<std::tuple<Streams, Preset, std::int64_t>, Bytes> kept;
  Bytes& model = kept[{streams, settings.preset, settings.max_error}];
  if (!model.empty()) return model;
  const Size3 size{40, 33, 29};
  const auto voxels = voxels_of<T>(size, streams, 3);
  const TrainingBrick training{shape_of(size), view_of(voxels, size)};
  settings.axis_order = kStraightOrder;
  settings.access = Access::none;
  model = train_grey_model(voxel_type_of<T>(), std::span(&training, 1), settings)->serialized();
  return model;
}

/// The codec of the same model with these axes cut.
template <class T>
std::unique_ptr<BrickCodec> cut_codec(Bytes model, std::uint8_t cut_axes) {
  model[1] = cut_axes;
  return parse_grey_model(voxel_type_of<T>(), model);
}

/// The levels above 0 of a brick, opened; segment 0 is not shown.
std::unique_ptr<BrickParts> opened(const BrickCodec& codec, const BrickShape& shape,
                                   VoxelType type, const EncodedBrick& brick) {
  std::vector<ByteSpan> segments = spans_of(brick);
  segments[0] = {};
  return codec.open_parts(shape, type, brick.range, segments);
}

ByteSpan bytes_of(const EncodedBrick& brick, const BrickParts::Part& part) {
  return ByteSpan(brick.segments[0]).subspan(part.offset, part.length);
}

template <class T>
std::vector<T> whole_of(const BrickCodec& codec, const BrickShape& shape,
                        const EncodedBrick& brick) {
  std::vector<T> out(static_cast<std::size_t>(shape.size[0].voxel_count()));
  codec.decode(shape, voxel_type_of<T>(), brick.range, spans_of(brick), 0, out.data());
  return out;
}

/// Decodes every part alone, last one first, into an array of the brick; no voxel beside a part is
/// touched.
template <class T>
std::vector<T> parts_together(const BrickParts& opened, const EncodedBrick& brick,
                              const Size3& size) {
  std::vector<T> out(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = opened.parts().size(); i-- > 0;) {
    const BrickParts::Part& part = opened.parts()[i];
    const std::int64_t first = (part.box.lo.z * size.y + part.box.lo.y) * size.x + part.box.lo.x;
    opened.decode(i, bytes_of(brick, part), {out.data() + first, size.x, size.x * size.y});
  }
  return out;
}

/// Decodes boxes of all parts at once; no voxel beside them is touched.
template <class T>
void expect_boxes(const BrickParts& opened, const EncodedBrick& brick, const Size3& size,
                  const std::vector<T>& whole) {
  std::mt19937 random(static_cast<unsigned>(size.x + size.y));
  std::vector<T> out(whole.size());
  std::vector<T> expected(whole.size());
  const auto place = [&](std::int64_t x, std::int64_t y, std::int64_t z) {
    return static_cast<std::size_t>((z * size.y + y) * size.x + x);
  };
  std::vector<BrickParts::Wanted> wanted;
  for (std::size_t i = 0; i < opened.parts().size(); ++i) {
    const BrickParts::Part& part = opened.parts()[i];
    Box box = part.box;
    for (int axis = 0; axis < 3; ++axis) {
      using Place = std::uniform_int_distribution<std::int64_t>;
      box.lo[axis] = Place(box.lo[axis], box.hi[axis] - 1)(random);
      box.hi[axis] = Place(box.lo[axis] + 1, box.hi[axis])(random);
    }
    T* const first = out.data() + place(box.lo.x, box.lo.y, box.lo.z);
    wanted.push_back({i, bytes_of(brick, part), box, {first, size.x, size.x * size.y}});
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          expected[place(x, y, z)] = whole[place(x, y, z)];
        }
      }
    }
  }
  opened.decode(wanted);
  ASSERT_EQ(out, expected);
}

/// A whole brick, and its parts, come back; `expected` when the model is lossless.
template <class T>
void expect_parts(const BrickCodec& codec, const BrickShape& shape, const std::vector<T>& voxels,
                  std::int64_t max_error) {
  const EncodedBrick brick = codec.encode(shape, view_of(voxels, shape.size[0]));
  const std::vector<T> whole = whole_of<T>(codec, shape, brick);
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const auto difference = static_cast<std::int64_t>(whole[i]) - std::int64_t{voxels[i]};
    ASSERT_LE(std::abs(difference), max_error) << i;
  }
  const auto parts = opened(codec, shape, voxel_type_of<T>(), brick);
  const std::uint8_t cut_axes = codec.serialized()[1];
  const bool is_stored = brick.segments.back().empty();
  ASSERT_EQ(parts != nullptr,
            !is_stored && grey::has_parts(grey::in_order(shape, codec.axis_order()), cut_axes));
  if (!parts) return;
  ASSERT_EQ(parts_together<T>(*parts, brick, shape.size[0]), whole);
  expect_boxes(*parts, brick, shape.size[0], whole);
}

template <class T>
class PartsOfType : public ::testing::Test {};
using SomeTypes = ::testing::Types<std::uint8_t, std::int16_t, std::int32_t>;
TYPED_TEST_SUITE(PartsOfType, SomeTypes);

const Size3 kPartSizes[] = {{64, 64, 64}, {33, 40, 35}, {64, 34, 17}, {63, 33, 1}, {32, 64, 32}};

/// With every cut, every kind of stream and both predictors; of the sizes one full brick for each.
TYPED_TEST(PartsOfType, DecodeAloneToWhatTheWholeBrickHolds) {
  using T = TypeParam;
  for (const Preset preset : {Preset::small, Preset::fast}) {
    for (const Streams streams : {Streams::residuals, Streams::edges, Streams::gaps,
                                  Streams::cells}) {
      const auto trained = trained_on<T>(streams, {.preset = preset});
      for (std::uint8_t cut = 0; cut <= kAllCuts; ++cut) {
        const auto codec = cut_codec<T>(trained, cut);
        const bool is_large_turn = cut % 4 == static_cast<std::uint8_t>(streams);
        for (const Size3& size : kPartSizes) {
          if (size.voxel_count() > 100000 && !is_large_turn) continue;
          SCOPED_TRACE(::testing::Message()
                       << "streams " << static_cast<int>(streams) << " cut " << int{cut} << " "
                       << size.x << "x" << size.y << "x" << size.z);
          expect_parts(*codec, shape_of(size), voxels_of<T>(size, streams, 8), 0);
        }
        // Flat bricks: z is not halved on the way to level 1.
        const Size3 flat{64, 40, 16};
        expect_parts(*codec, shape_of(flat, {1, 1, 4}), voxels_of<T>(flat, streams, 9), 0);
      }
    }
  }
}

TYPED_TEST(PartsOfType, StayWithinTheMaximumError) {
  using T = TypeParam;
  for (const Preset preset : {Preset::small, Preset::fast}) {
    // The smaller one rounds voxels, the larger one details.
    for (const std::int64_t max_error : {1, 12}) {
      const auto trained =
          trained_on<T>(Streams::cells, {.preset = preset, .max_error = max_error});
      for (const std::uint8_t cut : std::initializer_list<std::uint8_t>{0, 1, 6, 7}) {
        const auto codec = cut_codec<T>(trained, cut);
        for (const Size3& size : {Size3{33, 40, 35}, Size3{40, 33, 64}}) {
          for (const Streams streams : {Streams::residuals, Streams::cells}) {
            expect_parts(*codec, shape_of(size), voxels_of<T>(size, streams, 8), max_error);
          }
        }
      }
    }
  }
}

TEST(Parts, FollowTheAxesOfTheModel) {
  const Size3 size{64, 40, 33};
  const BrickShape shape = shape_of(size);
  const auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
  const Bytes straight = trained_on<std::int16_t>(Streams::residuals, {});
  for (std::size_t number = 0; number < grey::kAxisOrders.size(); ++number) {
    const AxisOrder& order = grey::kAxisOrders[number];
    Bytes model = straight;
    model[0] = static_cast<std::uint8_t>(model[0] | number << 2);
    for (const std::uint8_t cut : std::initializer_list<std::uint8_t>{1, 6}) {
      const auto codec = cut_codec<std::int16_t>(model, cut);
      ASSERT_EQ(codec->axis_order(), order);
      expect_parts(*codec, shape, voxels, 0);
      const EncodedBrick brick = codec->encode(shape, view_of(voxels, size));
      const auto parts = opened(*codec, shape, VoxelType::int16, brick);
      ASSERT_TRUE(parts);
      // The second part lies behind the first along the first axis that is cut.
      const int axis = order[cut == 1 ? 0 : 1];
      EXPECT_EQ(parts->parts().back().box.hi, (Index3{size.x, size.y, size.z}));
      EXPECT_EQ(parts->parts()[1].box.lo[axis], 32);
    }
  }
}

/// At the end of a volume the last pair of a coarse brick has two weights: that of the last part.
TEST(Parts, OfCoarseBricksWeighTheLastPair) {
  const Size3 volume{64 * 33 + 5, 64 * 3 + 1, 64 * 34 - 7};
  const Levels levels(volume, choose_halvings(volume, {1, 1, 1}));
  const BrickShape shape = brick_shape(levels, 1, {0, 0, 0});
  ASSERT_EQ(shape.size[0], (Size3{34, 4, 34}));
  ASSERT_FALSE(shape.weights.last_pair(0, 34).are_equal());
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const Bytes trained = trained_on<std::int16_t>(Streams::residuals, {preset});
    for (std::uint8_t cut = 0; cut <= kAllCuts; ++cut) {
      expect_parts(*cut_codec<std::int16_t>(trained, cut), shape,
                   voxels_of<std::int16_t>(shape.size[0], Streams::residuals, 2), 0);
    }
  }
}

/// Where nothing is cut in two, a brick has no parts and its bytes are those of an uncut one.
TEST(Parts, SmallBricksHaveNone) {
  const Bytes trained = trained_on<std::int16_t>(Streams::residuals, {});
  const auto cut = cut_codec<std::int16_t>(trained, kAllCuts);
  const auto uncut = cut_codec<std::int16_t>(trained, 0);
  for (const Size3& size : {Size3{32, 32, 32}, Size3{32, 20, 1}, Size3{2, 2, 2}}) {
    const BrickShape shape = shape_of(size);
    const auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
    const EncodedBrick brick = cut->encode(shape, view_of(voxels, size));
    EXPECT_EQ(brick.segments, uncut->encode(shape, view_of(voxels, size)).segments);
    EXPECT_FALSE(opened(*cut, shape, VoxelType::int16, brick));
  }
  const Size3 size{33, 20, 20};
  const auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
  const EncodedBrick brick = cut->encode(shape_of(size), view_of(voxels, size));
  const auto parts = opened(*cut, shape_of(size), VoxelType::int16, brick);
  ASSERT_TRUE(parts);
  EXPECT_EQ(parts->parts().size(), 2u);
}

TEST(Parts, StoredAndUniformBricksHaveNone) {
  const Size3 size{64, 64, 64};
  const BrickShape shape = shape_of(size);
  const auto codec =
      cut_codec<std::uint16_t>(trained_on<std::uint16_t>(Streams::residuals, {}), kAllCuts);
  std::mt19937 random(5);
  std::vector<std::uint16_t> noise(static_cast<std::size_t>(size.voxel_count()));
  for (auto& voxel : noise) voxel = static_cast<std::uint16_t>(random());
  const EncodedBrick stored = codec->encode(shape, view_of(noise, size));
  ASSERT_TRUE(stored.segments.back().empty());
  EXPECT_FALSE(opened(*codec, shape, VoxelType::uint16, stored));
  EXPECT_EQ(whole_of<std::uint16_t>(*codec, shape, stored), noise);
  const std::vector<std::uint16_t> one_value(noise.size(), 9);
  const EncodedBrick uniform = codec->encode(shape, view_of(one_value, size));
  EXPECT_FALSE(opened(*codec, shape, VoxelType::uint16, uniform));
}

/// A damaged part is rejected; the others come back.
TEST(Parts, DoNotDependOnEachOther) {
  const Size3 size{64, 40, 64};
  const BrickShape shape = shape_of(size);
  const auto voxels = voxels_of<std::int16_t>(size, Streams::cells, 4);
  std::mt19937 random(6);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto codec =
        cut_codec<std::int16_t>(trained_on<std::int16_t>(Streams::cells, {preset}), kAllCuts);
    const EncodedBrick good = codec->encode(shape, view_of(voxels, size));
    const auto parts = opened(*codec, shape, VoxelType::int16, good);
    ASSERT_TRUE(parts);
    ASSERT_EQ(parts->parts().size(), 8u);
    for (std::size_t hit = 0; hit < 8; ++hit) {
      const BrickParts::Part& damaged = parts->parts()[hit];
      ASSERT_GT(damaged.length, 0u);
      EncodedBrick bad = good;
      bad.segments[0][damaged.offset + random() % damaged.length] ^= 1;
      for (std::size_t i = 0; i < 8; ++i) {
        const BrickParts::Part& part = parts->parts()[i];
        const Size3 box = part.box.size();
        std::vector<std::int16_t> out(static_cast<std::size_t>(box.voxel_count()));
        const VoxelTarget target{out.data(), box.x, box.x * box.y};
        if (i == hit) {
          EXPECT_THROW(parts->decode(i, bytes_of(bad, part), target), Error);
          continue;
        }
        parts->decode(i, bytes_of(bad, part), target);
        for (std::int64_t z = 0, at = 0; z < box.z; ++z) {
          for (std::int64_t y = 0; y < box.y; ++y) {
            for (std::int64_t x = 0; x < box.x; ++x, ++at) {
              const std::int64_t in_brick =
                  ((z + part.box.lo.z) * size.y + y + part.box.lo.y) * size.x + x + part.box.lo.x;
              ASSERT_EQ(out[static_cast<std::size_t>(at)],
                        voxels[static_cast<std::size_t>(in_brick)]);
            }
          }
        }
      }
    }
  }
}

/// Waves and grain; of a range of more than 16 bits, or with cells of one value.
std::vector<std::int32_t> some_waves(const Size3& size, std::int64_t height, bool has_cells) {
  std::mt19937 random(static_cast<unsigned>(size.z + height));
  std::vector<std::int32_t> voxels;
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const std::int64_t x = i % size.x, y = i / size.x % size.y, z = i / size.x / size.y;
    const double wave = std::sin(0.21 * static_cast<double>(x + 2 * y)) +
                        std::cos(0.17 * static_cast<double>(z - y));
    const auto grain = static_cast<std::int32_t>(random() % 16);
    const auto voxel = static_cast<std::int32_t>(static_cast<double>(height) * wave) + grain;
    voxels.push_back(has_cells && z < 20 ? 7 : voxel);
  }
  return voxels;
}

/// Of one model: of other sizes, with flagged cells, of a wider range, and in any order.
TEST(Parts, OfSeveralBricksDecodeTogether) {
  struct Opening {
    Size3 size;
    std::vector<std::int32_t> voxels;
    EncodedBrick brick;
    std::vector<ByteSpan> segments;
    std::vector<std::int32_t> out;
  };
  std::mt19937 random(14);
  std::vector<Opening> openings;
  std::vector<TrainingBrick> training;
  const Size3 sizes[] = {{64, 64, 64}, {64, 64, 40}, {64, 64, 64}, {64, 40, 64}, {64, 64, 64}};
  openings.reserve(std::size(sizes));
  for (const Size3& size : sizes) {
    const std::size_t i = openings.size();
    Opening& own = openings.emplace_back();
    own.size = size;
    own.voxels = some_waves(size, i == 4 ? 90000 : 300, i == 2);
    own.out.resize(own.voxels.size());
    training.push_back({shape_of(size), view_of(own.voxels, size)});
  }
  for (const Preset preset : {Preset::small, Preset::fast}) {
    CodecSettings settings{preset};
    settings.axis_order = kStraightOrder;
    settings.access = Access::none;
    const auto codec = cut_codec<std::int32_t>(
        train_grey_model(VoxelType::int32, training, settings)->serialized(), kAllCuts);
    std::vector<CodedBrick> coded;
    for (Opening& own : openings) {
      own.brick = codec->encode(shape_of(own.size), view_of(own.voxels, own.size));
      own.segments = spans_of(own.brick);
      coded.push_back({shape_of(own.size), own.brick.range, own.segments});
    }
    const auto parts = codec->open_together(VoxelType::int32, coded);
    std::vector<BrickParts::WantedOf> wanted;
    for (std::size_t i = 0; i < openings.size(); ++i) {
      Opening& own = openings[i];
      ASSERT_TRUE(parts[i]) << i;
      for (std::size_t k = 0; k < parts[i]->parts().size(); ++k) {
        const BrickParts::Part& part = parts[i]->parts()[k];
        const Index3& lo = part.box.lo;
        std::int32_t* const first =
            own.out.data() + (lo.z * own.size.y + lo.y) * own.size.x + lo.x;
        wanted.push_back({parts[i].get(),
                          {k, bytes_of(own.brick, part), part.box,
                           {first, own.size.x, own.size.x * own.size.y}}});
      }
    }
    for (int round = 0; round < 3; ++round) {
      for (Opening& own : openings) std::fill(own.out.begin(), own.out.end(), 0);
      parts.front()->decode_together(wanted);
      for (const Opening& own : openings) ASSERT_EQ(own.out, own.voxels);
      std::shuffle(wanted.begin(), wanted.end(), random);
    }
  }
}

/// Above level 0 one of several is damaged; others are opened afterwards, in the same work spaces.
TEST(Parts, OfSeveralBricksOpenWhereEachOpensAlone) {
  const Size3 sizes[] = {{64, 64, 64}, {33, 64, 40}, {64, 40, 33}, {64, 33, 1}};
  std::mt19937 random(77);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto codec =
        cut_codec<std::int16_t>(trained_on<std::int16_t>(Streams::cells, {preset}), kAllCuts);
    std::vector<EncodedBrick> good;
    for (const Size3& size : sizes) {
      const auto voxels = voxels_of<std::int16_t>(size, Streams::cells, 4);
      good.push_back(codec->encode(shape_of(size), view_of(voxels, size)));
    }
    int failures = 0;
    for (int round = 0; round < 24; ++round) {
      std::vector<EncodedBrick> bricks = good;
      Bytes& bytes = bricks[random() % 4].segments[1 + random() % 5];
      if (!bytes.empty() && round % 4 > 0) bytes[random() % bytes.size()] ^= 0x10;
      if (!bytes.empty() && round % 4 > 1) bytes.resize(1 + random() % bytes.size());
      std::vector<std::vector<ByteSpan>> segments;
      std::vector<CodedBrick> coded;
      std::vector<bool> opens;
      for (std::size_t i = 0; i < bricks.size(); ++i) {
        segments.push_back(spans_of(bricks[i]));
        coded.push_back({shape_of(sizes[i]), bricks[i].range, segments.back()});
        try {
          opens.push_back(codec->open_together(VoxelType::int16, std::span(&coded[i], 1))[0] !=
                          nullptr);
        } catch (const Error&) {
          opens.push_back(false);
        }
      }
      const bool do_all = std::find(opens.begin(), opens.end(), false) == opens.end();
      failures += do_all ? 0 : 1;
      if (do_all) {
        const auto parts = codec->open_together(VoxelType::int16, coded);
        for (std::size_t i = 0; i < parts.size(); ++i) {
          EXPECT_EQ(parts_together<std::int16_t>(*parts[i], bricks[i], sizes[i]),
                    whole_of<std::int16_t>(*codec, coded[i].shape, bricks[i]));
        }
      } else {
        EXPECT_THROW(codec->open_together(VoxelType::int16, coded), Error);
      }
    }
    EXPECT_GT(failures, 6);
    EXPECT_LT(failures, 24);
  }
}

/// Some parts hold one value alone: they have no bytes, beside others that do.
TEST(Parts, WithoutBytesStandBesideOthers) {
  const Size3 size{64, 64, 64};
  const BrickShape shape = shape_of(size);
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const auto codec =
        cut_codec<std::int16_t>(trained_on<std::int16_t>(Streams::cells, {preset}), kAllCuts);
    for (const unsigned empty : {0x01u, 0x02u, 0x55u, 0x3fu}) {
      auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
      for (std::size_t i = 0; i < voxels.size(); ++i) {
        const std::size_t part = (i >> 17 & 1) << 2 | (i >> 11 & 1) << 1 | (i >> 5 & 1);
        if ((empty >> part & 1) != 0) voxels[i] = 7;
      }
      expect_parts(*codec, shape, voxels, 0);
      const EncodedBrick brick = codec->encode(shape, view_of(voxels, size));
      const auto parts = opened(*codec, shape, VoxelType::int16, brick);
      ASSERT_TRUE(parts);
      for (std::size_t part = 0; part < 8; ++part) {
        EXPECT_EQ(parts->parts()[part].length == 0, (empty >> part & 1) != 0) << part;
      }
    }
  }
}

/// Writes the checksums of parts into their list, as they are now.
void prove_anew(EncodedBrick& brick, const std::vector<BrickParts::Part>& parts) {
  Bytes& list = brick.segments[1];
  std::size_t at = 0;
  for (const BrickParts::Part& part : parts) {
    while (list[at] >= 128) ++at;  // the length
    ++at;
    if (part.length == 0) continue;
    const std::uint32_t crc = crc32c(ByteSpan(brick.segments[0]).subspan(part.offset, part.length));
    for (int i = 0; i < 4; ++i) list[at++] = static_cast<std::uint8_t>(crc >> 8 * i);
  }
}

/// Parts may be decoded at the same time: what is wrong with the first of two is reported, however
/// early the second one fails.
TEST(Parts, OfTwoDamagedOnesTheFirstIsReported) {
  const Size3 size{64, 40, 40};
  const BrickShape shape = shape_of(size);
  const auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
  const auto codec = cut_codec<std::int16_t>(
      trained_on<std::int16_t>(Streams::residuals, {.preset = Preset::fast}), 6);
  const EncodedBrick good = codec->encode(shape, view_of(voxels, size));
  const auto parts = opened(*codec, shape, VoxelType::int16, good)->parts();
  const auto failure = [&](EncodedBrick bad) -> std::string {
    prove_anew(bad, parts);
    try {
      whole_of<std::int16_t>(*codec, shape, bad);
    } catch (const Error& error) {
      return error.what();
    }
    return "nothing";
  };
  // The first one has another last word, the second one the length of no plain bits.
  EncodedBrick late = good;
  late.segments[0][parts[1].offset - 1] ^= 1;
  EncodedBrick early = good;
  for (std::uint64_t i = 0; i < 4; ++i) early.segments[0][parts[1].offset + i] = 0xff;
  EncodedBrick both = late;
  both.segments[0] = early.segments[0];
  both.segments[0][parts[1].offset - 1] ^= 1;
  EXPECT_NE(failure(late), "nothing");
  EXPECT_NE(failure(early), "nothing");
  EXPECT_NE(failure(early), failure(late));
  EXPECT_EQ(failure(both), failure(late));
}

/// Lengths that do not add up to the segment, a list that is cut short, or bytes behind the last
/// part.
TEST(Parts, AWrongListIsCorrupt) {
  const Size3 size{64, 40, 33};
  const BrickShape shape = shape_of(size);
  const auto voxels = voxels_of<std::int16_t>(size, Streams::residuals, 4);
  const auto codec =
      cut_codec<std::int16_t>(trained_on<std::int16_t>(Streams::residuals, {}), kAllCuts);
  const EncodedBrick good = codec->encode(shape, view_of(voxels, size));
  const auto expect_corrupt = [&](const EncodedBrick& bad, const std::string& what) {
    try {
      whole_of<std::int16_t>(*codec, shape, bad);
      ADD_FAILURE() << what;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << what;
    }
  };
  EncodedBrick bad = good;
  bad.segments[0].push_back(0);
  expect_corrupt(bad, "a byte behind the parts");
  bad = good;
  bad.segments[0].pop_back();
  expect_corrupt(bad, "a byte too few");
  // The list starts with the length of the first part.
  bad = good;
  bad.segments[1][0] ^= 1;
  expect_corrupt(bad, "another length");
  bad = good;
  bad.segments[1].resize(10);
  expect_corrupt(bad, "half a list");
}

/// Where a brick takes few bytes, parts take many of them; nobody gets these without asking.
TEST(Parts, AreLeftOutWhereTheyCostTooMuch) {
  const Size3 size{64, 64, 64};
  const BrickShape shape = shape_of(size);
  const auto cut_of = [&](const std::vector<std::uint8_t>& voxels, const CodecSettings& settings) {
    const TrainingBrick training{shape, view_of(voxels, size)};
    return train_grey_model(VoxelType::uint8, std::span(&training, 1), settings)->serialized()[1];
  };
  std::mt19937 random(3);
  std::vector<std::uint8_t> few(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = 0; i < 90; ++i) few[random() % few.size()] = 9;
  EXPECT_EQ(cut_of(few, {.preset = Preset::fast}), 0);
  EXPECT_EQ(cut_of(few, {.preset = Preset::fast, .access = Access::slices}), 6) << "asked for";
  const auto much = voxels_of<std::uint8_t>(size, Streams::residuals, 4);
  EXPECT_EQ(cut_of(much, {.preset = Preset::fast}), 6);
  EXPECT_EQ(cut_of(much, {.preset = Preset::small}), 0);
  EXPECT_EQ(cut_of(much, {.preset = Preset::fast, .access = Access::none}), 0);
  EXPECT_EQ(cut_of(much, {.preset = Preset::fast, .access = Access::boxes}), 7);
}

/// A model with flags that this version does not know is newer, not damaged.
TEST(Parts, UnknownCutsAreOfALaterVersion) {
  for (const int flag : {8, 16, 32, 64, 128}) {
    Bytes model = trained_on<std::uint8_t>(Streams::residuals, {});
    model[1] = static_cast<std::uint8_t>(model[1] | flag);
    try {
      parse_grey_model(VoxelType::uint8, model);
      ADD_FAILURE() << flag;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::unsupported_version) << flag;
    }
  }
}

}  // namespace
}  // namespace octavo
