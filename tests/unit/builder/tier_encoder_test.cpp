#include "octavo/builder/tier_encoder.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <cstring>

#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/file/write/writer.h"

namespace octavo {
namespace {

// Keeps the voxels as they are; off by `error` for the last voxel of the brick whose first voxel is
// `broken`.
class CopyingCodec final : public BrickCodec {
 public:
  explicit CopyingCodec(int broken, int error = 1) : broken_(broken), error_(error) {}
  VolumeKind kind() const noexcept override { return VolumeKind::grey; }
  Bytes serialized() const override { return {}; }
  EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const override {
    EncodedBrick encoded;
    encoded.range = {0, 255};
    encoded.segments.resize(static_cast<std::size_t>(shape.level_count));
    const auto* const voxels = static_cast<const std::uint8_t*>(brick.voxels);
    for (std::int64_t z = 0; z < brick.size.z; ++z)
      for (std::int64_t y = 0; y < brick.size.y; ++y) {
        const std::uint8_t* const row = voxels + z * brick.plane_stride + y * brick.row_stride;
        encoded.segments[0].insert(encoded.segments[0].end(), row, row + brick.size.x);
      }
    encoded.parent = voxels[0];
    if (voxels[0] == broken_) {
      encoded.segments[0].back() = static_cast<std::uint8_t>(encoded.segments[0].back() + error_);
    }
    return encoded;
  }
  void decode(const BrickShape&, VoxelType, const ValueRange&, std::span<const ByteSpan> segments,
              int, void* out) const override {
    std::memcpy(out, segments[0].data(), segments[0].size());
  }
  std::int64_t decode_parent(const BrickShape&, VoxelType, const ValueRange&,
                             std::span<const ByteSpan> segments) const override {
    return segments[0][0];
  }

 private:
  int broken_;
  int error_;
};

class RecordingWriter final : public FileWriter {
 public:
  void add_model(const Bytes&) override { models_before.push_back(parents.size()); }
  void add_brick(int, const EncodedBrick& brick) override {
    parents.push_back(brick.parent);
    errors.push_back(brick.max_error);
  }
  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    plane_digests.insert(plane_digests.end(), digests.begin(), digests.end());
  }
  void add_part(Part) override {}
  void end_group(std::uint32_t) override { groups_before.push_back(parents.size()); }
  const std::vector<JournalGroup>& resumed() const override { return none_; }
  Bytes first_model() const override { return {}; }
  std::int64_t kept_layers() const override { return 0; }
  WrittenErrors written_errors() const override { return {}; }
  void set_metadata(const Metadata&) override {}
  void finish() override {}
  std::uint64_t bytes_written() const override { return 0; }
  std::vector<std::int64_t> parents;
  std::vector<Sha256Digest> plane_digests;
  std::vector<std::int64_t> errors;
  std::vector<std::size_t> models_before;  ///< bricks that came before each model
  std::vector<std::size_t> groups_before;  ///< bricks that came before each end of a group

 private:
  std::vector<JournalGroup> none_;
};

// 3 x 2 x 2 bricks of uint8, each filled with its number in [z][y][x] order, with one odd voxel.
struct NumberedBricks {
  Levels levels{Size3{150, 100, 70}, std::vector<HalvingMask>(8, kHalveAll)};
  std::vector<std::uint8_t> voxels;
  NumberedBricks() {
    for (std::int64_t z = 0; z < 70; ++z)
      for (std::int64_t y = 0; y < 100; ++y)
        for (std::int64_t x = 0; x < 150; ++x)
          voxels.push_back(static_cast<std::uint8_t>((z / 64 * 2 + y / 64) * 3 + x / 64));
  }
  VoxelBlock block() {
    return {reinterpret_cast<std::byte*>(voxels.data()), VoxelType::uint8, {150, 100, 70}, 0};
  }
};

Model copying_model(int broken, int error = 1) {
  return {std::make_shared<CopyingCodec>(broken, error),
          std::make_shared<CopyingCodec>(broken, error),
          {}};
}

TEST(TierEncoder, BricksArriveInFileOrderAndParentsInVoxelOrder) {
  NumberedBricks volume;
  for (const int threads : {1, 2, 5}) {
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(threads);
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress);
    encoder.encode(copying_model(-1), volume.block());
    // O-code order inside a layer: digit 2x + y.
    EXPECT_EQ(writer.parents, (std::vector<std::int64_t>{0, 3, 1, 4, 2, 5, 6, 9, 7, 10, 8, 11}));
    const auto parents = encoder.take_parents();
    ASSERT_EQ(parents.size(), 12u);
    for (std::size_t i = 0; i < 12; ++i) EXPECT_EQ(static_cast<std::size_t>(parents[i]), i);
  }
}

TEST(TierEncoder, DigestsAreThoseOfThePlanesAsReadersSeeThem) {
  constexpr std::size_t kPlaneBytes = 150 * 100;
  for (const int threads : {1, 4}) {
    for (const int error : {0, 2}) {
      NumberedBricks volume;
      std::vector<std::uint8_t> decoded = volume.voxels;
      // Brick 4, at (1, 1, 0), ends with voxel (127, 99, 63).
      const std::size_t last = kPlaneBytes * 63 + 150 * 99 + 127;
      if (error > 0) decoded[last] = static_cast<std::uint8_t>(decoded[last] + error);
      RecordingWriter writer;
      NoProgress progress;
      Workers workers(threads);
      ErrorBound bound;
      bound.codes = error;
      TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress, bound);
      encoder.encode(copying_model(error > 0 ? 4 : -1, error), volume.block());
      ASSERT_EQ(writer.plane_digests.size(), 70u);
      for (std::size_t z = 0; z < 70; ++z) {
        EXPECT_EQ(writer.plane_digests[z],
                  sha256(ByteSpan(decoded).subspan(z * kPlaneBytes, kPlaneBytes)))
            << "plane " << z << ", error " << error;
      }
    }
  }
}

TEST(TierEncoder, ABrickThatDoesNotDecodeToItsVoxelsIsNamed) {
  NumberedBricks volume;
  for (const int threads : {1, 4}) {
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(threads);
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress);
    try {
      encoder.encode(copying_model(10), volume.block());
      FAIL() << "the brick was kept";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::internal);
      EXPECT_NE(error.detail().find("brick (1, 1, 1) of tier 0"), std::string::npos)
          << error.what();
    }
  }
}

// The two brick layers of a volume as blocks.
std::array<VoxelBlock, 2> layers_of(NumberedBricks& volume) {
  std::array<VoxelBlock, 2> layers{volume.block(), volume.block()};
  layers[0].size.z = 64;
  layers[1] = {layers[0].voxels + 150 * 100 * 64, VoxelType::uint8, {150, 100, 6}, 64};
  return layers;
}

TEST(TierEncoder, BlocksStartedTogetherArriveInOrderEachBehindItsModel) {
  NumberedBricks volume;
  const auto layers = layers_of(volume);
  for (const int threads : {1, 2, 5}) {
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(threads);
    std::atomic<int> done = 0;
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress);
    for (const VoxelBlock& layer : layers) {
      encoder.start(copying_model(-1), layer, true, [&] { ++done; });
    }
    encoder.finish();
    EXPECT_EQ(done, 2);
    EXPECT_EQ(writer.models_before, (std::vector<std::size_t>{0, 6}));
    EXPECT_EQ(writer.parents, (std::vector<std::int64_t>{0, 3, 1, 4, 2, 5, 6, 9, 7, 10, 8, 11}));
  }
}

TEST(TierEncoder, BlocksAreGivenBackAfterAFailureToo) {
  NumberedBricks volume;
  const auto layers = layers_of(volume);
  for (const int threads : {1, 4}) {
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(threads);
    std::atomic<int> done = 0;
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress);
    for (const VoxelBlock& layer : layers) {
      encoder.start(copying_model(4), layer, true, [&] { ++done; });
    }
    EXPECT_THROW(encoder.finish(), Error);
    EXPECT_EQ(done, 2);
    EXPECT_THROW(encoder.check(), Error);
    // Bricks before the broken one are kept, none behind it.
    EXPECT_EQ(writer.parents, (std::vector<std::int64_t>{0, 3, 1}));
  }
}

TEST(TierEncoder, ErrorsWithinTheBoundAreMeasuredAndOthersRejected) {
  for (const int error : {1, 2, 3}) {
    NumberedBricks volume;
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(2);
    ErrorBound bound;
    bound.codes = 2;
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress, bound);
    if (error > 2) {
      EXPECT_THROW(encoder.encode(copying_model(4, error), volume.block()), Error);
      continue;
    }
    encoder.encode(copying_model(4, error), volume.block());
    // Brick 4 is the fourth of the first layer.
    EXPECT_EQ(writer.errors, (std::vector<std::int64_t>{0, 0, 0, error, 0, 0, 0, 0, 0, 0, 0, 0}));
  }
}

TEST(TierEncoder, FloatVoxelsAreComparedThemselves) {
  NumberedBricks volume;
  const SampleCoding coding{VoxelType::uint8, 0.5, 0};
  std::vector<float> floats;
  for (const std::uint8_t code : volume.voxels) floats.push_back(0.5f * code + 0.125f);
  VoxelBlock block = volume.block();
  block.floats = floats.data();
  for (const double bound : {0.2, 0.124}) {
    RecordingWriter writer;
    NoProgress progress;
    Workers workers(2);
    TierEncoder encoder(volume.levels, 0, VoxelType::uint8, workers, writer, progress,
                        {.codes = 0, .voxels = bound, .coding = coding, .proposal = 1});
    if (bound < 0.125) {
      EXPECT_THROW(encoder.encode(copying_model(-1), block), Error);
      continue;
    }
    encoder.encode(copying_model(-1), block);
    // 0.125 / 0.2 in 1024ths, rounded up.
    EXPECT_EQ(writer.errors, std::vector<std::int64_t>(12, 640));
  }
}

}  // namespace
}  // namespace octavo
