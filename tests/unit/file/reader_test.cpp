#include <gtest/gtest.h>

#include <atomic>
#include <random>
#include <thread>

#include "octavo/file/pieces.h"
#include "octavo/file/layer_order.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/verify.h"
#include "octavo/file/write/writer.h"
#include "octavo/octree/o_code.h"
#include "support/counting_source.h"
#include "support/sample_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using namespace octavo::testing;

struct Case {
  Size3 size;
  VoxelType type;
  Pattern pattern;
  VolumeKind kind;
};

const Case kCases[] = {
    {{1, 1, 1}, VoxelType::uint8, Pattern::constant, VolumeKind::grey},
    {{1, 1, 200}, VoxelType::uint16, Pattern::gradient, VolumeKind::grey},
    {{130, 70, 65}, VoxelType::int16, Pattern::noisy_half, VolumeKind::grey},
    {{65, 129, 131}, VoxelType::uint8, Pattern::noisy_half, VolumeKind::labels},
    {{17, 19, 23}, VoxelType::int32, Pattern::gradient, VolumeKind::grey},
    {{300, 2, 2}, VoxelType::uint32, Pattern::gradient, VolumeKind::labels},
};

Box random_box(const Size3& size, std::mt19937& random) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    std::uniform_int_distribution<std::int64_t> position(0, size[axis] - 1);
    const std::int64_t a = position(random);
    const std::int64_t b = position(random);
    box.lo[axis] = std::min(a, b);
    box.hi[axis] = std::max(a, b) + 1;
  }
  return box;
}

TEST(Reader, EveryLevelComesBackWhole) {
  for (const Case& c : kCases) {
    SampleVolume volume = make_sample(c.size, c.type, c.pattern, c.kind);
    const auto reader = open_bytes(sample_file_bytes(volume));
    for (int level = 0; level < volume.levels.count(); ++level) {
      const Box all = box_of(volume.levels.size(level));
      EXPECT_EQ(read_samples(*reader, all, level), expected_samples(volume, all, level));
    }
  }
}

TEST(Reader, AnyBoxAtAnyLevelEqualsTheCrop) {
  std::mt19937 random(7);
  for (const Case& c : kCases) {
    SampleVolume volume = make_sample(c.size, c.type, c.pattern, c.kind);
    const auto reader = open_bytes(sample_file_bytes(volume));
    for (int level = 0; level < volume.levels.count(); ++level) {
      for (int i = 0; i < 20; ++i) {
        const Box box = random_box(volume.levels.size(level), random);
        ASSERT_EQ(read_samples(*reader, box, level), expected_samples(volume, box, level));
      }
    }
  }
}

TEST(Reader, HalvesOnlyTheAxesOfTheMask) {
  SampleVolume volume = make_sample({128, 128, 40}, VoxelType::int16, Pattern::noisy_half);
  volume.description.geometry.spacing_mm = {1, 1, 5};
  volume.levels = Levels({128, 128, 40}, choose_halvings({128, 128, 40}, {1, 1, 5}));
  volume.samples.resize(1);
  for (int level = 1; level < volume.levels.count(); ++level) {
    volume.samples.emplace_back(
        static_cast<std::size_t>(volume.levels.size(level).voxel_count() * 2));
  }
  const auto reader = open_bytes(sample_file_bytes(volume));
  EXPECT_NE(reader->levels().halving(0), kHalveAll);
  for (int level = 0; level < volume.levels.count(); ++level) {
    const Box all = box_of(volume.levels.size(level));
    EXPECT_EQ(read_samples(*reader, all, level), expected_samples(volume, all, level));
  }
}

TEST(Reader, OpensWithTwoReads) {
  for (const Case& c : kCases) {
    SampleVolume volume = make_sample(c.size, c.type, c.pattern, c.kind);
    const auto source = std::make_shared<CountingSource>(sample_file_bytes(volume));
    FileReader::open(source);
    EXPECT_EQ(source->reads, 2);
  }
}

TEST(Reader, OpensAFileWithALargeIndexWithTwoReads) {
  SampleVolume volume = make_sample({kMaxAxis, 1, 1}, VoxelType::uint16, Pattern::gradient);
  // With such metadata, index pages are too far from the end to come with it.
  const std::string text = "\"" + std::string(60'000, 't') + "\"";
  std::string texts = text;
  for (int i = 1; i < 8; ++i) texts += "," + text;
  volume.description.metadata = Metadata::read("{\"texts\":[" + texts + "]}");
  const auto source = std::make_shared<CountingSource>(sample_file_bytes(volume));
  const auto reader = FileReader::open(source);
  EXPECT_EQ(source->reads, 2);
  EXPECT_EQ(reader->description().metadata.text(), volume.description.metadata.text());

  // A page, the model, the four pieces of the brick.
  const Box box{{kMaxAxis - 5, 0, 0}, {kMaxAxis, 1, 1}};
  EXPECT_EQ(read_samples(*reader, box, 0), expected_samples(volume, box, 0));
  EXPECT_EQ(source->reads, 2 + 1 + 1 + 4);
  for (int level = 0; level < volume.levels.count(); ++level) {
    const Box all = box_of(volume.levels.size(level));
    EXPECT_EQ(read_samples(*reader, all, level), expected_samples(volume, all, level));
  }
}

TEST(Reader, UniformBricksNeedNoRead) {
  SampleVolume volume = make_sample({64, 64, 128}, VoxelType::int16, Pattern::noisy_half);
  const auto source = std::make_shared<CountingSource>(sample_file_bytes(volume));
  const auto reader = FileReader::open(source);
  read_samples(*reader, {{0, 0, 0}, {64, 64, 64}}, 0);
  EXPECT_EQ(source->reads, 2);
}

TEST(Reader, ACachedBrickIsNotReadAgain) {
  SampleVolume volume = make_sample({64, 64, 64}, VoxelType::int16, Pattern::gradient);
  const auto source = std::make_shared<CountingSource>(sample_file_bytes(volume));
  const auto reader = FileReader::open(source);
  read_samples(*reader, {{1, 2, 3}, {9, 9, 9}}, 0);
  const int reads = source->reads;
  read_samples(*reader, {{30, 2, 3}, {64, 9, 9}}, 0);
  EXPECT_EQ(source->reads, reads);
}

TEST(Reader, GivesTheDescriptionBack) {
  SampleVolume volume = make_sample({20, 30, 40}, VoxelType::uint16, Pattern::gradient);
  VolumeDescription& written = volume.description;
  written.geometry.origin_mm = {-10.5, 3, 1e-3};
  written.geometry.direction = {0, 1, 0, -1, 0, 0, 0, 0, 1};
  written.rescale = {0.1, -1024};
  written.metadata = Metadata::read("{\"a\": [1, 2]}");
  const auto reader = open_bytes(sample_file_bytes(volume));
  const VolumeDescription& read = reader->description();
  EXPECT_EQ(read.size, written.size);
  EXPECT_EQ(read.geometry, written.geometry);
  EXPECT_EQ(read.rescale, written.rescale);
  EXPECT_EQ(read.metadata.text(), written.metadata.text());
  EXPECT_EQ(reader->format_version(), "1.0");
  EXPECT_EQ(reader->range(), (ValueRange{0, 19 + 2 * 29 + 3 * 39}));
}

TEST(Reader, TellsWhatTheFileIs) {
  SampleVolume volume = make_sample({20, 30, 40}, VoxelType::uint16, Pattern::gradient);
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  EXPECT_EQ(reader->file_bytes(), bytes.size());
  EXPECT_EQ(reader->source().size(), bytes.size());
  EXPECT_EQ(reader->max_error(), 0);
  EXPECT_EQ(reader->achieved_error(), 0);
  EXPECT_EQ(reader->axis_order(), kStraightOrder);
  EXPECT_TRUE(reader->thumbnail().empty());
  volume.samples[0][5] ^= 1;
  EXPECT_NE(open_bytes(sample_file_bytes(volume))->build_id(), reader->build_id());
}

TEST(Reader, APieceIsItsBytesInTheFile) {
  SampleVolume volume = make_sample({70, 20, 130}, VoxelType::int16, Pattern::noisy_half);
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  const BrickEntry noisy = reader->brick(0, {1, 0, 1});
  const BrickEntry uniform = reader->brick(0, {1, 0, 0});
  ASSERT_TRUE(uniform.is_uniform());
  ASSERT_EQ(noisy.pieces.size(), 4u);
  for (int piece = 0; piece < kTierPieces; ++piece) {
    const BrickEntry::StoredPiece& stored = noisy.pieces[static_cast<std::size_t>(piece)];
    const auto from = bytes.begin() + static_cast<std::ptrdiff_t>(stored.offset);
    const auto length = static_cast<std::ptrdiff_t>(stored.length);
    EXPECT_GT(length, 0);
    EXPECT_EQ(reader->read_piece(noisy, piece), Bytes(from, from + length));
    EXPECT_TRUE(reader->read_piece(uniform, piece).empty());
  }
  std::int16_t voxel = 0;
  for (const int level : {-1, kTierLevels}) {
    EXPECT_THROW(reader->read_piece(noisy, level), Error);
    EXPECT_THROW(reader->read_brick(noisy, level, &voxel), Error);
  }
}

TEST(Reader, ReadingEndsAtTheNextBrickOnceItsWatcherAsksForThat) {
  SampleVolume volume = make_sample({200, 130, 70}, VoxelType::uint8, Pattern::gradient);
  const auto source = byte_source_of(sample_file_bytes(volume), "sample.8vo");
  const Box all = box_of(volume.levels.size(0));
  std::vector<std::uint8_t> out(static_cast<std::size_t>(all.size().voxel_count()));
  for (const int threads : {1, 3}) {
    const testing::StoppingProgress watcher(2);
    ReaderOptions options;
    options.watcher = &watcher;
    const auto reader = FileReader::open(source, options);
    try {
      read_parallel(*reader, all, 0, out.data(), threads);
      ADD_FAILURE() << "read to the end";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
  }
}

TEST(Reader, MetadataBeyondTheLimitOfTheReaderAreRejected) {
  SampleVolume volume = make_sample({2, 2, 2}, VoxelType::uint8, Pattern::gradient);
  const auto source = byte_source_of(sample_file_bytes(volume), "sample.8vo");
  ReaderOptions options;
  options.max_metadata_bytes = volume.description.metadata.text().size();
  EXPECT_NO_THROW(FileReader::open(source, options));
  --options.max_metadata_bytes;
  try {
    FileReader::open(source, options);
    ADD_FAILURE() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    EXPECT_EQ(error.path(), "sample.8vo");
  }
}

/// A file of one brick under fitting checksums, of whatever model and segments.
std::vector<std::uint8_t> file_of(const Bytes& model, const std::vector<Bytes>& segments) {
  const SampleVolume volume = make_sample({4, 4, 4}, VoxelType::uint8, Pattern::gradient);
  MemoryStorage storage;
  const auto writer =
      FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1, {});
  writer->add_model(model);
  EncodedBrick brick;
  brick.range = {0, 5};
  brick.segments = segments;
  writer->add_plane_digests(digests_of_planes(volume.samples[0], 4));
  writer->add_brick(0, brick);
  writer->finish();
  return *storage.files.at("a.8vo");
}

TEST(Reader, NamesTheModelOrBrickThatCannotBeDecoded) {
  const std::vector<Bytes> segments = {Bytes(64, 3), Bytes(8, 2), Bytes(1, 1)};
  const struct {
    Bytes model;
    std::vector<Bytes> segments;
    std::string words;
  } cases[] = {
      {{'x'}, segments, "model 0 at byte 512: model of another size"},
      {{'r', 'a', 'w'}, {Bytes(63, 3), segments[1], segments[2]},
       "brick o-code 0x0 level 0 at byte 515: segment of another size"},
  };
  const Box all{{0, 0, 0}, {4, 4, 4}};
  EXPECT_EQ(read_samples(*open_bytes(file_of({'r', 'a', 'w'}, segments)), all, 0), segments[0]);
  for (const auto& c : cases) {
    const std::vector<std::uint8_t> bytes = file_of(c.model, c.segments);
    const auto reader = open_bytes(bytes);
    try {
      read_samples(*reader, all, 0);
      ADD_FAILURE() << c.words;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt);
      EXPECT_EQ(std::string(error.what()), "sample.8vo: " + c.words);
      EXPECT_EQ(error.offset(), c.words.find("512") != std::string::npos ? 512u : 515u);
    }
    NoProgress progress;
    const VerifyReport report = verify_file(byte_source_of(bytes, "sample.8vo"), {}, progress);
    ASSERT_EQ(report.damage_count, 1);
    EXPECT_NE(report.damages.front().detail.find("of another size"), std::string::npos);
  }
}

TEST(Reader, LevelSummariesAddUpToTheBricks) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half);
  volume.model_layers = 2;
  const auto reader = open_bytes(sample_file_bytes(volume));
  for (int level = 0; level < volume.levels.count(); ++level) {
    const int tier = Levels::tier_of(level);
    const Size3 grid = volume.levels.brick_grid(tier);
    LevelSummary sum;
    for (std::int64_t z = 0; z < grid.z; ++z) {
      for (Index3 position : layer_order(grid)) {
        position.z = z;
        const BrickEntry entry = reader->brick(tier, position);
        EXPECT_EQ(entry.code, interleave(position));
        EXPECT_EQ(entry.model, tier == 0 ? static_cast<std::uint32_t>(z / 2) : 0u);
        ++sum.bricks;
        sum.uniform_bricks += entry.is_uniform();
        // Levels 3, 4 and 5 of a tier share a piece, which is counted with the first of them.
        const int in_brick = level % kTierLevels;
        if (in_brick >= kTierPieces) continue;
        sum.bytes += entry.pieces[static_cast<std::size_t>(in_brick)].length;
      }
    }
    const LevelSummary told = reader->level_summary(level);
    EXPECT_EQ(told.bricks, sum.bricks);
    EXPECT_EQ(told.uniform_bricks, sum.uniform_bricks);
    EXPECT_EQ(told.bytes, sum.bytes);
    EXPECT_EQ(told.is_in_finer, level % kTierLevels > 3);
  }
}

TEST(Reader, RejectsWhatLiesOutside) {
  SampleVolume volume = make_sample({20, 20, 20}, VoxelType::uint8, Pattern::gradient);
  const auto reader = open_bytes(sample_file_bytes(volume));
  std::uint8_t voxel = 0;
  constexpr std::int64_t kFar = std::numeric_limits<std::int64_t>::max();
  const Box bad[] = {{{0, 0, 0}, {0, 1, 1}},
                     {{0, 0, 20}, {1, 1, 21}},
                     {{-1, 0, 0}, {1, 1, 1}},
                     {{0, 0, 0}, {kFar, kFar, kFar}}};
  for (const Box& box : bad) EXPECT_THROW(reader->read(box, 0, &voxel), Error);
  EXPECT_THROW(reader->read({{0, 0, 0}, {1, 1, 1}}, -1, &voxel), Error);
  EXPECT_THROW(reader->read({{0, 0, 0}, {1, 1, 1}}, 6, &voxel), Error);
  EXPECT_THROW(reader->brick(0, {1, 0, 0}), Error);
  EXPECT_THROW(reader->brick(1, {0, 0, 0}), Error);
}

TEST(Reader, AnyNumberOfThreadsReadsWhatOneDoes) {
  SampleVolume volume = make_sample({200, 140, 130}, VoxelType::int16, Pattern::noisy_half);
  ReaderOptions options;
  options.cache_bytes = 1 << 20;
  const auto reader =
      FileReader::open(byte_source_of(sample_file_bytes(volume), "sample.8vo"), options);
  std::atomic<int> wrong = 0;
  const auto work = [&](unsigned seed) {
    std::mt19937 random(seed);
    for (int i = 0; i < 40; ++i) {
      const int level = static_cast<int>(random() % 4);
      const Box box = random_box(volume.levels.size(level), random);
      if (read_samples(*reader, box, level) != expected_samples(volume, box, level)) ++wrong;
    }
  };
  std::vector<std::thread> threads;
  for (unsigned seed = 0; seed < 8; ++seed) threads.emplace_back(work, seed);
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, 0);
}

TEST(Reader, ParallelReadEqualsSerialRead) {
  SampleVolume volume = make_sample({200, 140, 130}, VoxelType::int16, Pattern::noisy_half);
  const auto reader = open_bytes(sample_file_bytes(volume));
  std::mt19937 random(3);
  for (int i = 0; i < 20; ++i) {
    const int level = static_cast<int>(random() % 4);
    const Box box = random_box(volume.levels.size(level), random);
    Bytes out(static_cast<std::size_t>(box.size().voxel_count() * 2));
    read_parallel(*reader, box, level, out.data(), 4);
    ASSERT_EQ(out, expected_samples(volume, box, level));
    std::fill(out.begin(), out.end(), std::uint8_t{0});
    read_parallel(*reader, box, level, out.data(), 1);
    ASSERT_EQ(out, expected_samples(volume, box, level));
  }
  std::int16_t voxel = 0;
  const Box one{{0, 0, 0}, {1, 1, 1}};
  EXPECT_THROW(read_parallel(*reader, one, -1, &voxel, 4), Error);
  EXPECT_THROW(read_parallel(*reader, one, volume.levels.count(), &voxel, 4), Error);
  EXPECT_THROW(read_parallel(*reader, {}, 0, &voxel, 4), Error);
  EXPECT_THROW(read_parallel(*reader, {{199, 0, 0}, {201, 1, 1}}, 0, &voxel, 4), Error);
}

}  // namespace
}  // namespace octavo
