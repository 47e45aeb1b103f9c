// Boxes read through sources that hold what was planned, and nothing else.
#include "octavo/file/box_plan.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <map>
#include <mutex>
#include <random>
#include <string>
#include <thread>

#include "octavo/builder/builder.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/storage/sparse_source.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

using namespace octavo::testing;

struct PlannedVolume {
  const char* name;
  Size3 size;
  VoxelType type;
  BuildOptions options;
};

const PlannedVolume kPlannedVolumes[] = {
    {"whole bricks", {100, 70, 200}, VoxelType::int16, {.preset = Preset::fast}},
    {"slices", {130, 70, 66}, VoxelType::uint8,
     {.preset = Preset::fast, .access = Access::slices}},
    {"boxes", {70, 100, 130}, VoxelType::int16,
     {.preset = Preset::small, .access = Access::boxes}},
    {"max error", {70, 80, 66}, VoxelType::float32,
     {.preset = Preset::fast, .access = Access::boxes, .max_error = 9}},
    {"exact floats", {70, 66, 30}, VoxelType::float32, {.preset = Preset::fast}},
    {"labels", {150, 70, 66}, VoxelType::uint16, {.kind = VolumeKind::labels}},
    {"details", {70, 80, 66}, VoxelType::int16, {.preset = Preset::fast, .keep_details = 1}},
    {"flat", {700, 3, 1}, VoxelType::uint16, {.preset = Preset::fast}},
    {"one voxel", {1, 1, 1}, VoxelType::uint8, {}},
};

/// Noise beside voxels that are all alike, so that some bricks are uniform or stored.
std::vector<std::uint8_t> built_file(const PlannedVolume& volume) {
  VolumeDescription description;
  description.size = volume.size;
  description.type = volume.type;
  description.kind = volume.options.kind;
  std::mt19937 random(4);
  std::vector<std::byte> voxels;
  with_voxel_type(volume.type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    const bool has_labels = description.kind == VolumeKind::labels;
    for (std::int64_t i = 0; i < volume.size.voxel_count(); ++i) {
      const auto x = static_cast<double>(i % volume.size.x);
      const double wave = std::sin(0.1 * x) + std::cos(0.003 * static_cast<double>(i) / 100);
      const double noise = static_cast<double>(random() % 8);
      const double grey = x >= 128 ? 7 : 60 + 25 * wave + noise;
      const auto voxel = static_cast<T>(has_labels ? std::floor(grey / 20) : grey);
      const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
      voxels.insert(voxels.end(), bytes, bytes + sizeof voxel);
    }
  });
  const auto source = make_memory_source(description, voxels);
  MemoryStorage storage;
  NoProgress progress;
  build_file(*source, storage, "planned.8vo", volume.options, progress);
  return *storage.files.at("planned.8vo");
}

/// Every file is built once.
const std::vector<std::uint8_t>& file_of(const PlannedVolume& volume) {
  static std::map<std::string, std::vector<std::uint8_t>> files;
  auto& file = files[volume.name];
  if (file.empty()) file = built_file(volume);
  return file;
}

/// Holds what was put in, and remembers which of that was read.
class WatchedSource final : public ByteSource {
 public:
  explicit WatchedSource(const std::vector<std::uint8_t>& file)
      : file_(file), held_(file.size(), "watched") {}

  void put(const ByteRange& range) {
    held_.put(range.offset, std::span(file_).subspan(range.offset, range.length));
  }
  std::uint64_t size() const override { return held_.size(); }
  const std::string& name() const override { return held_.name(); }
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    return held_.missing(ranges);
  }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    held_.read(offset, out);
    read_ranges.push_back({offset, out.size()});
  }

  mutable std::vector<ByteRange> read_ranges;

 private:
  const std::vector<std::uint8_t>& file_;
  SparseSource held_;
};

/// Brings what plans name until nothing is missing. Returns what that was.
template <class Plan>
std::vector<ByteRange> bring(WatchedSource& source, Plan plan_next, int most_plans) {
  std::vector<ByteRange> brought;
  for (int count = 0;; ++count) {
    const ReadPlan plan = plan_next();
    EXPECT_LE(plan.needed_bytes, total_bytes(plan.ranges));
    EXPECT_TRUE(plan.is_complete || !plan.ranges.empty());
    if (plan.ranges.empty()) break;
    EXPECT_LT(count, most_plans);
    for (const ByteRange& range : plan.ranges) source.put(range);
    brought.insert(brought.end(), plan.ranges.begin(), plan.ranges.end());
    if (plan.is_complete) {
      EXPECT_TRUE(plan_next().ranges.empty());
      break;
    }
  }
  return joined(brought, kNoGaps);
}

std::shared_ptr<FileReader> opened(const std::shared_ptr<WatchedSource>& source,
                                   const ReaderOptions& options) {
  bring(*source, [&] { return plan_of_opening(*source, options); }, 2);
  return FileReader::open(source, options);
}

Box any_box(const Size3& size, std::mt19937& random) {
  Box box;
  const auto kind = random() % 3;
  for (int axis = 0; axis < 3; ++axis) {
    const auto sides = static_cast<std::uint64_t>(size[axis]);
    box.lo[axis] = static_cast<std::int64_t>(random() % sides);
    const auto left = static_cast<std::uint64_t>(size[axis] - box.lo[axis]);
    const std::uint64_t length = kind == 0 ? 1 : 1 + random() % left;
    box.hi[axis] = box.lo[axis] + static_cast<std::int64_t>(length);
    if (kind == 2 && axis != static_cast<int>(random() % 3)) {
      box.lo[axis] = 0;
      box.hi[axis] = size[axis];
    }
  }
  return box;
}

Bytes voxels_of(const FileReader& reader, const Box& box, int level) {
  Bytes out(static_cast<std::size_t>(box.size().voxel_count() *
                                     bytes_per_voxel(reader.description().type)));
  reader.read(box, level, out.data());
  return out;
}

TEST(BoxPlan, ABoxIsReadFromThePlannedBytesAndFromAllOfThem) {
  std::mt19937 random(7);
  for (const PlannedVolume& volume : kPlannedVolumes) {
    const std::vector<std::uint8_t> file = file_of(volume);
    const auto whole = FileReader::open(byte_source_of(file, "whole"));
    for (int i = 0; i < 30; ++i) {
      ReaderOptions options;
      options.max_tail_bytes = i % 2 == 0 ? 0 : std::uint64_t{1} << 20;
      const auto source = std::make_shared<WatchedSource>(file);
      const auto reader = opened(source, options);
      source->read_ranges.clear();
      const int level = i % 3 == 0 ? static_cast<int>(random() % static_cast<unsigned>(
                                                          reader->levels().count()))
                                   : 0;
      const Box box = any_box(reader->levels().size(level), random);
      const auto plan_next = [&] { return reader->ranges_of(box, level, kNoGaps); };
      const std::vector<ByteRange> planned = bring(*source, plan_next, 3);
      ASSERT_EQ(voxels_of(*reader, box, level), voxels_of(*whole, box, level))
          << volume.name << ", box " << i;
      // What opening brought may be read again.
      const std::vector<ByteRange> read = joined(source->read_ranges, kNoGaps);
      SparseBytes touched;
      for (const ByteRange& range : read) {
        touched.put(range.offset, std::span(file).subspan(range.offset, range.length));
      }
      ASSERT_TRUE(touched.missing(planned).empty()) << volume.name << ", box " << i;
    }
  }
}

TEST(BoxPlan, WhatIsThereIsNotPlannedAgain) {
  std::mt19937 random(8);
  for (const PlannedVolume& volume : kPlannedVolumes) {
    const std::vector<std::uint8_t> file = file_of(volume);
    const auto whole = FileReader::open(byte_source_of(file, "whole"));
    const auto source = std::make_shared<WatchedSource>(file);
    const auto reader = opened(source, {.cache_bytes = 1 << 19, .max_tail_bytes = 0});
    std::uint64_t brought = 0;
    for (int i = 0; i < 40; ++i) {
      const int level = static_cast<int>(random() % static_cast<unsigned>(
                                             std::min(reader->levels().count(), 3)));
      const Box box = any_box(reader->levels().size(level), random);
      const auto plan_next = [&] { return reader->ranges_of(box, level, kNoGaps); };
      brought += total_bytes(bring(*source, plan_next, 3));
      ASSERT_EQ(voxels_of(*reader, box, level), voxels_of(*whole, box, level)) << volume.name;
    }
    EXPECT_LE(brought, file.size());
    EXPECT_TRUE(whole->ranges_of(box_of(volume.size), 0).ranges.empty());
  }
}

TEST(BoxPlan, AVoxelOfACutBrickTakesItsPart) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[2]);
  const auto source = std::make_shared<WatchedSource>(file);
  const auto reader = opened(source, {});
  const BrickEntry brick = reader->brick(0, {0, 0, 0});
  std::uint64_t all = 0;
  for (const auto& piece : brick.pieces) all += piece.length;
  const Box first{{1, 1, 1}, {2, 2, 2}};
  const auto model_and_coarse = reader->ranges_of(first, 0);
  EXPECT_FALSE(model_and_coarse.is_complete);
  const auto brought =
      bring(*source, [&] { return reader->ranges_of(first, 0, kNoGaps); }, 3);
  const Box whole_brick{{0, 0, 0}, {64, 64, 64}};
  const ReadPlan rest = reader->ranges_of(whole_brick, 0);
  EXPECT_TRUE(rest.is_complete);
  EXPECT_GT(rest.needed_bytes, all / 2);
  EXPECT_LT(rest.needed_bytes, brick.pieces.front().length);
}

TEST(BoxPlan, BoxesThatAreNotInsideAreRejected) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[1]);
  const auto reader = FileReader::open(byte_source_of(file, "whole"));
  EXPECT_THROW(reader->ranges_of({{0, 0, 0}, {1, 1, 1}}, 99), Error);
  EXPECT_THROW(reader->ranges_of({{0, 0, 0}, {1, 1, 67}}, 0), Error);
  EXPECT_THROW(reader->ranges_of({{5, 5, 5}, {5, 6, 6}}, 0), Error);
}

/// A list of parts that lies leads nowhere: the reader says that the brick is damaged.
TEST(BoxPlan, ADamagedListOfPartsIsFoundByTheReaderNotByThePlan) {
  const std::vector<std::uint8_t> good = file_of(kPlannedVolumes[2]);
  const BrickEntry brick =
      FileReader::open(byte_source_of(good, "good"))->brick(0, {0, 0, 0});
  std::mt19937 random(2);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> bad = good;
    bad[brick.pieces[1].offset + random() % 60] ^= static_cast<std::uint8_t>(1 + random() % 255);
    const auto source = std::make_shared<WatchedSource>(bad);
    const auto reader = opened(source, {});
    const Box box{{1, 1, 1}, {40, 2, 2}};
    bring(*source, [&] { return reader->ranges_of(box, 0, kNoGaps); }, 3);
    try {
      voxels_of(*reader, box, 0);
      ADD_FAILURE() << "a damaged brick was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    }
  }
}

/// Brings what is asked for itself, and keeps no more than a limit.
class FetchingSource final : public ByteSource {
 public:
  FetchingSource(const std::vector<std::uint8_t>& file, std::uint64_t kept)
      : file_(byte_source_of(file, "fetched")), kept_(kept), held_(file.size(), "fetched") {}

  std::uint64_t size() const override { return file_->size(); }
  const std::string& name() const override { return file_->name(); }
  std::uint64_t fetched_bytes_kept() const override { return kept_; }
  std::uint64_t bytes_per_round() const override { return round_bytes; }
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    return held_.missing(ranges);
  }
  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override {
    return held_.hold(ranges);
  }
  void fetch(std::span<const ByteRange> ranges) const override {
    const std::lock_guard lock(mutex_);
    ++round_count;
    fetched_bytes += total_bytes(ranges);
    for (const ByteRange& range : ranges) {
      held_.put(range.offset, read_arriving(*file_, range.offset, range.length));
      request_count += 1;
    }
    most_held = std::max(most_held, held_.byte_count());
    held_.shrink_to(kept_);
  }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    const ByteRange range{offset, out.size()};
    if (!held_.missing({&range, 1}).empty()) ++late_count;
    file_->read(offset, out);
  }

  std::uint64_t round_bytes = 0;
  mutable int round_count = 0;
  mutable std::uint64_t fetched_bytes = 0;
  mutable int request_count = 0;
  mutable std::atomic<int> late_count = 0;  ///< reads of what was not fetched
  mutable std::uint64_t most_held = 0;

 private:
  std::shared_ptr<ByteSource> file_;
  std::uint64_t kept_;
  mutable std::mutex mutex_;  // of fetching
  mutable SparseSource held_;
};

TEST(BoxPlan, ReadersFetchWhatABoxNeedsBeforeTheyReadIt) {
  std::mt19937 random(9);
  for (const PlannedVolume& volume : kPlannedVolumes) {
    const std::vector<std::uint8_t> file = file_of(volume);
    const auto whole = FileReader::open(byte_source_of(file, "whole"));
    const auto source = std::make_shared<FetchingSource>(file, std::uint64_t{1} << 30);
    const auto reader = FileReader::open(source, {.cache_bytes = 1 << 20, .max_tail_bytes = 0});
    source->late_count = 0;
    for (int i = 0; i < 20; ++i) {
      const Box box = any_box(volume.size, random);
      const Bytes expected = voxels_of(*whole, box, 0);
      Bytes found(expected.size());
      if (i % 2 == 0) reader->read(box, 0, found.data());
      else read_parallel(*reader, box, 0, found.data(), 3);
      ASSERT_EQ(found, expected) << volume.name;
    }
    EXPECT_EQ(source->late_count, 0) << volume.name;
  }
}

/// Where a round takes as long as so many bytes, bricks come whole and not their lists first.
TEST(BoxPlan, BytesThatAreNotNeededComeWhereTheyCostLessThanARound) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[2]);
  const auto whole = FileReader::open(byte_source_of(file, "whole"));
  const Box box{{1, 1, 1}, {70, 2, 40}};
  const Bytes expected = voxels_of(*whole, box, 0);
  struct Found {
    int rounds;
    std::uint64_t bytes;
  };
  const auto found_with = [&](std::uint64_t round_bytes, std::uint64_t kept) -> Found {
    const auto source = std::make_shared<FetchingSource>(file, kept);
    source->round_bytes = round_bytes;
    const auto reader = FileReader::open(source, {});
    source->round_count = 0;
    source->fetched_bytes = 0;
    source->late_count = 0;
    EXPECT_EQ(voxels_of(*reader, box, 0), expected);
    EXPECT_EQ(source->late_count, 0);
    return {source->round_count, source->fetched_bytes};
  };
  constexpr auto kPlenty = std::uint64_t{1} << 30;
  const Found sparing = found_with(0, kPlenty);
  const Found sooner = found_with(kPlenty, kPlenty);
  EXPECT_GT(sparing.rounds, 1);
  EXPECT_EQ(sooner.rounds, 1);
  EXPECT_GT(sooner.bytes, sparing.bytes);
  // No round is worth what it brings where that is little. Where little is kept, bricks that come
  // whole do not make it more rounds.
  EXPECT_EQ(found_with(100, kPlenty).bytes, sparing.bytes);
  for (const std::uint64_t kept : {2 * sparing.bytes, sooner.bytes, 2 * sooner.bytes}) {
    EXPECT_LE(found_with(kPlenty, kept).rounds, found_with(0, kept).rounds) << kept;
  }
}

TEST(BoxPlan, LargeBoxesAreFetchedInParts) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[0]);
  const auto whole = FileReader::open(byte_source_of(file, "whole"));
  const Box all = box_of(kPlannedVolumes[0].size);
  const Bytes expected = voxels_of(*whole, all, 0);
  for (const std::uint64_t part : {2u, 4u, 20u, 1000u}) {
    const std::uint64_t kept = file.size() / part;
    const auto source = std::make_shared<FetchingSource>(file, kept);
    const auto reader = FileReader::open(source, {});
    source->late_count = 0;
    Bytes found(expected.size());
    read_parallel(*reader, all, 0, found.data(), 2);
    EXPECT_EQ(found, expected);
    if (part > 4) continue;
    EXPECT_EQ(source->late_count, 0);
    EXPECT_LE(source->most_held, 2 * kept);
  }
}

/// However long decoding takes: each part is read once the next one has been fetched.
TEST(BoxPlan, APartStaysUntilTheNextOneIsHandedOut) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[0]);
  const auto whole = FileReader::open(byte_source_of(file, "whole"));
  const Box all = box_of(kPlannedVolumes[0].size);
  std::uint64_t largest_brick = 0;
  visit_cells(all, whole->levels().brick_side(0), [&](const Index3& position) {
    std::uint64_t bytes = 0;
    for (const auto& piece : whole->brick(0, position).pieces) bytes += piece.length;
    largest_brick = std::max(largest_brick, bytes);
    return true;
  });
  for (const int i : {0, 1, 2, 3, 4, 5}) {
    const std::uint64_t kept = file.size() / static_cast<std::uint64_t>(2 + i / 2);
    ASSERT_LT(largest_brick, kept);
    const auto source = std::make_shared<FetchingSource>(file, kept);
    const auto reader = FileReader::open(source, {});
    // What was put in long ago would be the first to go.
    const Box first{{0, 0, 0}, {64, 64, 64}};
    if (i % 2 == 0) reader->fetch({&first, 1}, 0);
    source->late_count = 0;
    std::vector<Box> parts;
    std::size_t read_count = 0;
    reader->for_fetched(all, 0, [&](const Box& part) {
      parts.push_back(part);
      // Once only: what was read is kept decoded.
      const std::size_t end = part.hi == all.hi ? parts.size() : parts.size() - 1;
      for (; read_count < end; ++read_count) {
        const Box& box = parts[read_count];
        ASSERT_EQ(voxels_of(*reader, box, 0), voxels_of(*whole, box, 0));
      }
    });
    EXPECT_GT(parts.size(), 1u);
    EXPECT_EQ(source->late_count, 0) << "run " << i;
    EXPECT_LE(source->most_held, 2 * kept);
  }
}

/// Of which other threads than the one that fetches read nothing before the second fetch begins.
class SecondFetch final : public ByteSource {
 public:
  SecondFetch(const std::vector<std::uint8_t>& file, std::uint64_t kept) : source_(file, kept) {}

  std::uint64_t size() const override { return source_.size(); }
  const std::string& name() const override { return source_.name(); }
  std::uint64_t fetched_bytes_kept() const override { return source_.fetched_bytes_kept(); }
  std::vector<ByteRange> missing(std::span<const ByteRange> ranges) const override {
    return source_.missing(ranges);
  }
  std::shared_ptr<const void> hold(std::span<const ByteRange> ranges) const override {
    return source_.hold(ranges);
  }
  void fetch(std::span<const ByteRange> ranges) const override {
    {
      const std::lock_guard lock(mutex_);
      ++fetch_count_;
      changed_.notify_all();
    }
    source_.fetch(ranges);
  }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (std::this_thread::get_id() != owner_) {
      std::unique_lock lock(mutex_);
      ++elsewhere_count;
      const bool is_fetched = changed_.wait_for(lock, std::chrono::seconds(60),
                                                [&] { return fetch_count_ > 1; });
      if (!is_fetched) ++late_count;
    }
    source_.read(offset, out);
  }
  int unfetched_count() const { return source_.late_count; }

  mutable std::atomic<int> elsewhere_count = 0;
  mutable std::atomic<int> late_count = 0;

 private:
  const std::thread::id owner_ = std::this_thread::get_id();
  FetchingSource source_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  mutable int fetch_count_ = 0;
};

TEST(BoxPlan, APartIsDecodedWhileTheNextOneIsFetched) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[0]);
  const auto whole = FileReader::open(byte_source_of(file, "whole"));
  const Box all = box_of(kPlannedVolumes[0].size);
  const Bytes expected = voxels_of(*whole, all, 0);
  for (const int threads : {1, 2}) {
    const auto source = std::make_shared<SecondFetch>(file, file.size());
    const auto reader = FileReader::open(source, {.lead_bytes = 0});
    const int unfetched = source->unfetched_count();
    Bytes found(expected.size());
    read_parallel(*reader, all, 0, found.data(), threads);
    EXPECT_EQ(found, expected);
    EXPECT_GT(source->elsewhere_count, 0);
    EXPECT_EQ(source->late_count, 0);
    EXPECT_EQ(source->unfetched_count(), unfetched);
  }
}

TEST(BoxPlan, AFailureOfAPartEndsTheReading) {
  const std::vector<std::uint8_t> file = file_of(kPlannedVolumes[0]);
  const Box all = box_of(kPlannedVolumes[0].size);
  std::vector<std::uint8_t> bad = file;
  bad[FileReader::open(byte_source_of(file, "whole"))->brick(0, {0, 0, 0}).pieces[0].offset] ^= 1;
  for (const int threads : {1, 2}) {
    const auto source = std::make_shared<FetchingSource>(bad, bad.size());
    Bytes found(static_cast<std::size_t>(2 * all.size().voxel_count()));
    try {
      read_parallel(*FileReader::open(source, {}), all, 0, found.data(), threads);
      ADD_FAILURE() << "a damaged brick was read";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
    }
  }
}

}  // namespace
}  // namespace octavo
