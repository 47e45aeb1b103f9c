// Damaged label segments and models end in Error{corrupt} or in wrong labels, never in anything
// else.
#include <gtest/gtest.h>

#include <random>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/error.h"

namespace octavo {
namespace {

struct Fixture {
  Levels levels{{21, 18, 13}, choose_halvings({21, 18, 13}, {1, 1, 1})};
  BrickShape shape = brick_shape(levels, 0, {0, 0, 0});
  std::vector<std::uint16_t> voxels;
  std::unique_ptr<BrickCodec> codec;
  EncodedBrick brick;

  explicit Fixture(unsigned seed) {
    std::mt19937 random(seed);
    const Size3& size = shape.size[0];
    for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
      const auto blob = static_cast<std::uint16_t>((i % size.x / 5 + i / (7 * size.x)) % 4 * 1000);
      voxels.push_back(random() % 30 == 0 ? static_cast<std::uint16_t>(random()) : blob);
    }
    const TrainingBrick training[] = {{shape, view()}};
    codec = train_label_model(VoxelType::uint16, training);
    brick = codec->encode(shape, view());
  }

  BrickView view() const {
    const Size3& size = shape.size[0];
    return {voxels.data(), VoxelType::uint16, size, size.x, size.x * size.y};
  }

  /// Decodes level 0; true when it was rejected as corrupt.
  bool is_rejected(const BrickCodec& by, const std::vector<Bytes>& segments) const {
    const std::vector<ByteSpan> spans(segments.begin(), segments.end());
    std::vector<std::uint16_t> out(voxels.size());
    try {
      by.decode(shape, VoxelType::uint16, brick.range, spans, 0, out.data());
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      return true;
    }
    return false;
  }
};

void mutate(Bytes& bytes, std::mt19937& random) {
  const int changes = 1 + static_cast<int>(random() % 4);
  for (int i = 0; i < changes && !bytes.empty(); ++i) {
    bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
  }
}

TEST(LabelDamage, TruncatedSegmentsAreRejectedOrDecodeToSomething) {
  const Fixture fixture(1);
  for (std::size_t level = 0; level < fixture.brick.segments.size(); ++level) {
    const Bytes whole = fixture.brick.segments[level];
    for (std::size_t length = 0; length < whole.size(); length += 1 + length / 16) {
      std::vector<Bytes> segments = fixture.brick.segments;
      segments[level].resize(length);
      fixture.is_rejected(*fixture.codec, segments);
    }
  }
}

TEST(LabelDamage, AddedBytesAreRejected) {
  const Fixture fixture(2);
  for (std::size_t level = 0; level < fixture.brick.segments.size(); ++level) {
    std::vector<Bytes> segments = fixture.brick.segments;
    segments[level].insert(segments[level].end(), 5, 0x5a);
    EXPECT_TRUE(fixture.is_rejected(*fixture.codec, segments)) << level;
  }
}

TEST(LabelDamage, MutatedSegmentsAreRejectedOrDecodeToSomething) {
  const Fixture fixture(3);
  std::mt19937 random(4);
  for (int i = 0; i < 600; ++i) {
    std::vector<Bytes> segments = fixture.brick.segments;
    mutate(segments[random() % segments.size()], random);
    fixture.is_rejected(*fixture.codec, segments);
  }
}

TEST(LabelDamage, MutatedModelsAreRejectedOrDecodeToSomething) {
  const Fixture fixture(5);
  const Bytes model = fixture.codec->serialized();
  std::mt19937 random(6);
  for (int i = 0; i < 200; ++i) {
    Bytes bytes = model;
    if (i % 5 == 0) bytes.resize(random() % bytes.size());
    mutate(bytes, random);
    try {
      const auto codec = parse_label_model(VoxelType::uint16, bytes);
      fixture.is_rejected(*codec, fixture.brick.segments);
    } catch (const Error& error) {
      // A longer palette than there is announces a model of a later version.
      const bool is_newer = error.kind() == ErrorKind::unsupported_version;
      EXPECT_TRUE(is_newer || error.kind() == ErrorKind::corrupt) << error.what();
    }
  }
}

}  // namespace
}  // namespace octavo
