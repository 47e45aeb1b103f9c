// Boxes of files, whose bricks have parts that decode alone or decode plane by plane.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <functional>
#include <random>
#include <string>

#include "octavo/builder/builder.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/core/error.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/reader.h"
#include "octavo/planes/memory_source.h"
#include "support/counting_source.h"
#include "support/memory_storage.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using namespace octavo::testing;

const Size3 kSize{100, 70, 66};

/// What voxels hold.
struct Waves {
  Size3 size = kSize;
  double height = 100;
  unsigned noise = 8;
};

std::vector<std::uint8_t> built(VoxelType type, const BuildOptions& options,
                                const Waves& waves = {}) {
  VolumeDescription description;
  const Size3& size = waves.size;
  description.size = size;
  description.type = type;
  std::mt19937 random(4);
  std::vector<std::byte> voxels;
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
      const double wave = std::sin(0.1 * static_cast<double>(i % size.x)) +
                          std::cos(0.003 * static_cast<double>(i / size.x));
      const auto voxel = static_cast<T>(400 + waves.height * wave +
                                        static_cast<double>(random() % waves.noise));
      const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
      voxels.insert(voxels.end(), bytes, bytes + sizeof voxel);
    }
  });
  const auto source = make_memory_source(description, voxels);
  MemoryStorage storage;
  NoProgress progress;
  build_file(*source, storage, "parts.8vo", options, progress);
  return *storage.files.at("parts.8vo");
}

Bytes box_of_reader(const FileReader& reader, const Box& box, int level = 0) {
  Bytes out(static_cast<std::size_t>(box.size().voxel_count() *
                                     bytes_per_voxel(reader.description().type)));
  reader.read(box, level, out.data());
  return out;
}

/// The same box cut out of all voxels of a level.
Bytes cut_out(const Bytes& all, const Box& box, std::size_t voxel_bytes,
              const Size3& size = kSize) {
  Bytes out;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const auto at = static_cast<std::size_t>((z * size.y + y) * size.x + box.lo.x);
      const auto* const row = all.data() + at * voxel_bytes;
      out.insert(out.end(), row, row + static_cast<std::size_t>(box.size().x) * voxel_bytes);
    }
  }
  return out;
}

Box voxel_at(const Index3& p) { return {p, {p.x + 1, p.y + 1, p.z + 1}}; }

/// A voxel (3), a plane along the axis of that number, or a small box (4).
Box random_box(const Size3& size, int form, std::mt19937& random) {
  Box box = box_of(size);
  for (int axis = 0; axis < 3; ++axis) {
    if (form < 3 && axis != form) continue;
    const std::int64_t most = form == 4 ? 40 : 1;
    box.lo[axis] = static_cast<std::int64_t>(random()) % size[axis];
    const std::int64_t length = 1 + static_cast<std::int64_t>(random()) % most;
    box.hi[axis] = std::min(box.lo[axis] + length, size[axis]);
  }
  return box;
}

/// Random boxes of every level. In front of each a brick of another file is decoded, so that
/// nothing of the file itself is left in the work space of the thread.
void expect_boxes(VoxelType type, const BuildOptions& how, const Waves& waves,
                  std::mt19937& random) {
  const auto bytes = built(type, how, waves);
  const auto other_bytes = built(type, how, {waves.size, -waves.height, waves.noise});
  const auto whole = FileReader::open(byte_source_of(bytes, "whole"), {.cache_bytes = 0});
  const auto other = FileReader::open(byte_source_of(other_bytes, "other"), {.cache_bytes = 0});
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(type));
  std::vector<Bytes> all;
  for (int level = 0; level < whole->levels().count(); ++level) {
    all.push_back(box_of_reader(*whole, box_of(whole->levels().size(level)), level));
  }
  for (const std::uint64_t cache_bytes : {std::uint64_t{0}, std::uint64_t{64} << 20}) {
    const auto reader =
        FileReader::open(byte_source_of(bytes, "parts"), {.cache_bytes = cache_bytes});
    for (int i = 0; i < 60; ++i) {
      const int level = i % 2 == 0 ? 0 : static_cast<int>(random() % all.size());
      const Size3& own = reader->levels().size(level);
      const Box box = random_box(own, i % 5, random);
      box_of_reader(*other, other->levels().brick_box(0, {0, 0, 0}));
      ASSERT_EQ(box_of_reader(*reader, box, level),
                cut_out(all[static_cast<std::size_t>(level)], box, voxel_bytes, own))
          << "level " << level << " box " << i;
    }
  }
}

TEST(ReaderParts, EveryBoxOfEveryLevelIsThatOfTheWholeVolume) {
  std::mt19937 random(7);
  const BuildOptions options[] = {{.preset = Preset::small},
                                  {.preset = Preset::small, .access = Access::boxes},
                                  {.preset = Preset::fast, .access = Access::slices},
                                  {.preset = Preset::fast, .access = Access::none, .max_error = 4},
                                  {.preset = Preset::fast,
                                   .access = Access::boxes,
                                   .max_error = 9}};
  for (const VoxelType type : {VoxelType::int16, VoxelType::float32}) {
    for (const BuildOptions& how : options) {
      for (const Waves& waves : {Waves{}, Waves{{20, 19, 21}, 100, 2000}}) {
        SCOPED_TRACE(::testing::Message() << voxel_type_name(type) << " options " << &how - options
                                          << " x " << waves.size.x);
        expect_boxes(type, how, waves, random);
      }
    }
  }
}

TEST(ReaderParts, AVoxelTakesTheBytesOfItsPartAndOfTheCoarserLevels) {
  const auto bytes = built(VoxelType::int16, {.preset = Preset::small, .access = Access::boxes});
  const auto source = std::make_shared<CountingSource>(bytes);
  const auto reader = FileReader::open(source, {});
  box_of_reader(*reader, voxel_at({99, 69, 65}));  // reads index and model
  const std::uint64_t before = source->bytes;
  box_of_reader(*reader, voxel_at({1, 1, 1}));
  const std::uint64_t cold = source->bytes - before;
  const BrickEntry brick = reader->brick(0, {0, 0, 0});
  std::uint64_t all = 0;
  for (const auto& piece : brick.pieces) all += piece.length;
  EXPECT_LT(cold, all / 2);
  // Another part of the brick: the coarser levels are kept.
  box_of_reader(*reader, voxel_at({50, 5, 5}));
  const std::uint64_t next = source->bytes - before - cold;
  EXPECT_LT(next, brick.pieces.front().length / 4);
  // The same part: nothing.
  box_of_reader(*reader, voxel_at({40, 1, 1}));
  EXPECT_EQ(source->bytes, before + cold + next);
  // What lies behind its first planes: all of it, once.
  for (int i = 0; i < 2; ++i) {
    box_of_reader(*reader, voxel_at({45, 20, 20}));
    box_of_reader(*reader, voxel_at({63, 31, 31}));
    EXPECT_EQ(source->bytes, before + cold + 2 * next);
  }
}

/// One plane after the other, along every axis: the first one is decoded by itself, the next one
/// with all that are left.
TEST(ReaderParts, PlanesThatFollowEachOtherTakeTheBytesTwiceAtMost) {
  for (const Access access : {Access::none, Access::slices, Access::boxes}) {
    const auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = access});
    const auto whole = FileReader::open(byte_source_of(bytes, "whole"), {.cache_bytes = 0});
    const Bytes all = box_of_reader(*whole, box_of(kSize));
    for (int axis = 0; axis < 3; ++axis) {
      for (const bool is_rising : {true, false}) {
        const auto source = std::make_shared<CountingSource>(bytes);
        const auto reader = FileReader::open(source, {});
        for (std::int64_t i = 0; i < kSize[axis]; ++i) {
          Box box = box_of(kSize);
          box.lo[axis] = is_rising ? i : kSize[axis] - 1 - i;
          box.hi[axis] = box.lo[axis] + 1;
          ASSERT_EQ(box_of_reader(*reader, box), cut_out(all, box, 2)) << axis << " " << i;
          const std::uint64_t taken = source->bytes;
          ASSERT_EQ(box_of_reader(*reader, box), cut_out(all, box, 2)) << axis << " " << i;
          EXPECT_EQ(source->bytes, taken) << "plane " << i << " once more, axis " << axis;
        }
        EXPECT_LT(source->bytes, 2 * bytes.size()) << axis;
      }
    }
  }
}

TEST(ReaderParts, ADamagedPartIsNamedAndTheOthersAreRead) {
  auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  const auto good = FileReader::open(byte_source_of(bytes, "good"));
  const BrickEntry brick = good->brick(0, {0, 0, 0});
  const Bytes expected = box_of_reader(*good, voxel_at({63, 63, 63}));
  bytes[brick.pieces.front().offset + 20] ^= 1;  // of the first part
  const auto bad = FileReader::open(byte_source_of(bytes, "bad"));
  EXPECT_EQ(box_of_reader(*bad, voxel_at({63, 63, 63})), expected);
  try {
    box_of_reader(*bad, voxel_at({0, 0, 0}));
    FAIL() << "a damaged part was read";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt);
    EXPECT_NE(std::string(error.what()).find("brick o-code 0x0 level 0"), std::string::npos);
    EXPECT_EQ(error.path(), "bad");
  }
  // So does the whole brick, by the checksum of its piece.
  EXPECT_THROW(box_of_reader(*bad, box_of(kSize)), Error);
}

/// One brick fails while the parts of others wait for their turn.
/// A file of which one byte is wrong until it was forgotten `heals_after` times.
class DamagedSource final : public ByteSource {
 public:
  DamagedSource(const std::vector<std::uint8_t>& file, std::uint64_t at, int heals_after)
      : file_(byte_source_of(file, "damaged")), at_(at), heals_after_(heals_after) {}
  std::uint64_t size() const override { return file_->size(); }
  const std::string& name() const override { return file_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    file_->read(offset, out);
    const bool is_in = at_ >= offset && at_ - offset < out.size();
    if (is_in && forgotten < heals_after_) out[at_ - offset] ^= 4;
  }
  bool forget(std::span<const ByteRange> ranges) const override {
    for (const ByteRange& range : ranges) {
      if (at_ >= range.offset && at_ < range.end()) ++forgotten;
    }
    return true;
  }

  mutable std::atomic<int> forgotten = 0;

 private:
  std::shared_ptr<ByteSource> file_;
  std::uint64_t at_;
  int heals_after_;
};

TEST(ReaderParts, DamagedBytesAreAskedForOnceMoreAndNotTwice) {
  const Box box{{3, 5, 7}, {99, 69, 66}};
  for (const Access access : {Access::slices, Access::boxes}) {
    const auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = access});
    const Bytes expected = box_of_reader(*FileReader::open(byte_source_of(bytes, "sound")), box);
    int damaged_count = 0;
    for (std::uint64_t step = 0; step < 30; ++step) {
      const std::uint64_t at = step * (bytes.size() - 1) / 29;
      const auto once = std::make_shared<DamagedSource>(bytes, at, 1);
      EXPECT_EQ(box_of_reader(*FileReader::open(once), box), expected) << at;
      EXPECT_LE(once->forgotten, 1) << at;
      const auto always = std::make_shared<DamagedSource>(bytes, at, 1000);
      try {
        EXPECT_EQ(box_of_reader(*FileReader::open(always), box), expected) << at;
      } catch (const Error&) {
        ++damaged_count;
        EXPECT_EQ(always->forgotten, 1) << at;
      }
    }
    EXPECT_GT(damaged_count, 15);
  }
}

TEST(ReaderParts, OfManyThreadsADamagedPartFailsOnceAndForAll) {
  auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  const auto good = FileReader::open(byte_source_of(bytes, "good"));
  bytes[good->brick(0, {0, 0, 0}).pieces.front().offset + 20] ^= 1;
  const auto bad = FileReader::open(byte_source_of(bytes, "bad"), {.cache_bytes = 0});
  Bytes out(static_cast<std::size_t>(kSize.voxel_count()) * sizeof(std::int16_t));
  for (int round = 0; round < 60; ++round) {
    EXPECT_THROW(read_parallel(*bad, box_of(kSize), 0, out.data(), 4), Error);
  }
}

/// Runs tasks last one first, and counts them.
ForEach backwards(std::int64_t& task_count) {
  return [&task_count](std::int64_t count, const std::function<void(std::int64_t)>& task) {
    task_count += count;
    for (std::int64_t i = count; i-- > 0;) task(i);
  };
}

void read_dense(const FileReader& reader, const Box& box, const ForEach& run, Bytes& out) {
  const Size3 size = box.size();
  out.assign(
      static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(reader.description().type)), 0);
  reader.read_in_tasks(box, 0, {out.data(), size.x, size.x * size.y}, run);
}

TEST(ReaderParts, InTasksEveryBoxIsWhatOneThreadReads) {
  const auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  const Box boxes[] = {box_of(kSize), {{0, 0, 0}, {64, 64, 64}}, {{3, 9, 20}, {61, 50, 33}},
                       {{30, 31, 5}, {100, 33, 6}}, {{99, 69, 65}, {100, 70, 66}}};
  for (const std::uint64_t cache_bytes : {std::uint64_t{0}, std::uint64_t{64} << 20}) {
    const auto reader = FileReader::open(byte_source_of(bytes, "parts"), {cache_bytes});
    const auto other = FileReader::open(byte_source_of(bytes, "other"), {cache_bytes});
    for (const Box& box : boxes) {
      const Bytes expected = box_of_reader(*other, box);
      Bytes found;
      std::int64_t task_count = 0;
      read_dense(*reader, box, backwards(task_count), found);
      ASSERT_EQ(found, expected);
      read_dense(*reader, box, for_each_parallel(3), found);
      ASSERT_EQ(found, expected);
      std::fill(found.begin(), found.end(), std::uint8_t{0});
      read_parallel(*reader, box, 0, found.data(), 4);
      ASSERT_EQ(found, expected);
    }
  }
}

TEST(ReaderParts, EachPartOfABrickIsATask) {
  const auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  const auto reader = FileReader::open(byte_source_of(bytes, "parts"), {.cache_bytes = 0});
  Bytes found;
  std::int64_t task_count = 0;
  read_dense(*reader, {{0, 0, 0}, {64, 64, 64}}, backwards(task_count), found);
  EXPECT_EQ(task_count, 8);
  task_count = 0;
  read_dense(*reader, {{1, 1, 1}, {63, 2, 2}}, backwards(task_count), found);
  EXPECT_EQ(task_count, 2);
}

TEST(ReaderParts, OfDamagedPartsTheFirstIsNamedWhateverTheOrderOfTasks) {
  auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  const auto good = FileReader::open(byte_source_of(bytes, "good"));
  const auto piece = good->brick(0, {0, 0, 0}).pieces.front();
  for (const std::uint64_t at : {20u, 40u}) bytes[piece.offset + piece.length * at / 100] ^= 1;
  const auto failure = [&](const ForEach& run) {
    const auto bad = FileReader::open(byte_source_of(bytes, "bad"));
    Bytes found;
    try {
      read_dense(*bad, {{0, 0, 0}, {64, 64, 64}}, run, found);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  std::int64_t task_count = 0;
  const std::string first = failure([](std::int64_t count, const auto& task) {
    for (std::int64_t i = 0; i < count; ++i) task(i);
  });
  EXPECT_NE(first.find("brick o-code 0x0 level 0"), std::string::npos) << first;
  EXPECT_EQ(failure(backwards(task_count)), first);
  EXPECT_EQ(failure(for_each_parallel(4)), first);
}

TEST(ReaderParts, ReadingInTasksEndsAtTheNextPartOnceItsWatcherAsksForThat) {
  const auto bytes = built(VoxelType::int16, {.preset = Preset::fast, .access = Access::boxes});
  for (const int calls : {0, 1, 4}) {
    const testing::StoppingProgress watcher(calls);
    ReaderOptions options;
    options.watcher = &watcher;
    const auto reader = FileReader::open(byte_source_of(bytes, "parts"), options);
    Bytes found;
    try {
      read_dense(*reader, {{0, 0, 0}, {64, 64, 64}}, for_each_parallel(3), found);
      ADD_FAILURE() << "read to the end";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
  }
}

}  // namespace
}  // namespace octavo
