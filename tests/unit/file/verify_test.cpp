#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <random>

#include "fault/reseal.h"
#include "octavo/core/error.h"
#include "octavo/file/layout.h"
#include "octavo/file/open_file.h"
#include "octavo/file/parallel_read.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/verify.h"
#include "octavo/file/write/writer.h"
#include "support/sample_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using namespace octavo::testing;

/// What the parts of a verification found, the last one first.
std::vector<VerifiedPart> parts_of(const std::vector<std::uint8_t>& bytes, std::int64_t count,
                                   const VerifyOptions& options) {
  NoProgress progress;
  std::vector<VerifiedPart> parts;
  for (std::int64_t number = count; number-- > 0;) {
    parts.push_back(
        verify_part(byte_source_of(bytes, "sample.8vo"), {number, count}, options, progress));
  }
  return parts;
}

void expect_same(const VerifyReport& joined, const VerifyReport& whole) {
  EXPECT_EQ(joined.brick_count, whole.brick_count);
  EXPECT_EQ(joined.damaged_brick_count, whole.damaged_brick_count);
  EXPECT_EQ(joined.unreachable_brick_count, whole.unreachable_brick_count);
  EXPECT_EQ(joined.piece_count, whole.piece_count);
  EXPECT_EQ(joined.damage_count, whole.damage_count);
  EXPECT_EQ(joined.repairable_count, whole.repairable_count);
  EXPECT_EQ(joined.file_bytes, whole.file_bytes);
  ASSERT_EQ(joined.damages.size(), whole.damages.size());
  for (std::size_t i = 0; i < whole.damages.size(); ++i) {
    EXPECT_EQ(joined.damages[i].what, whole.damages[i].what);
    EXPECT_EQ(joined.damages[i].detail, whole.damages[i].detail);
    EXPECT_EQ(joined.damages[i].offset, whole.damages[i].offset);
    EXPECT_EQ(joined.damages[i].flipped_byte, whole.damages[i].flipped_byte);
  }
}

/// The report, which is that of three parts as well.
VerifyReport verify_bytes(const std::vector<std::uint8_t>& bytes, int threads = 1) {
  NoProgress progress;
  VerifyOptions options;
  options.for_each = for_each_parallel(threads);
  const VerifyReport report = verify_file(byte_source_of(bytes, "sample.8vo"), options, progress);
  expect_same(joined_report(parts_of(bytes, 3, options), options.max_listed), report);
  return report;
}

TEST(Verify, ASoundFileHasNoDamage) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half);
  const VerifyReport report = verify_bytes(sample_file_bytes(volume), 3);
  EXPECT_TRUE(report.is_sound());
  EXPECT_EQ(report.brick_count, 3 * 2 * 3 + 1);
  EXPECT_GT(report.piece_count, 0);
}

TEST(Verify, NamesTheBrickTheLevelAndTheByte) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const BrickEntry entry = open_bytes(bytes)->brick(0, {1, 1, 1});
  const BrickEntry::StoredPiece& segment = entry.pieces[2];
  const std::uint64_t at = segment.offset + segment.length / 2;
  bytes[at] ^= 16;
  const VerifyReport report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damaged_brick_count, 1);
  const Damage& damage = report.damages.front();
  EXPECT_EQ(damage.what, "brick");
  EXPECT_EQ(damage.code, entry.code);
  EXPECT_EQ(damage.level, 2);
  EXPECT_EQ(damage.offset, segment.offset);
  EXPECT_EQ(damage.flipped_byte, at);
  EXPECT_EQ(damage.flipped_bit, 4);
}

TEST(Verify, OneDamagedBrickLeavesTheOthersReadable) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  bytes[open_bytes(bytes)->brick(0, {1, 1, 1}).pieces[0].offset] ^= 1;
  const auto reader = open_bytes(bytes);
  const Box first{{0, 0, 0}, {64, 64, 64}};
  EXPECT_EQ(read_samples(*reader, first, 0), expected_samples(volume, first, 0));
  EXPECT_THROW(read_samples(*reader, {{64, 64, 64}, {65, 65, 65}}, 0), Error);
  const Box coarse = box_of(volume.levels.size(1));
  EXPECT_EQ(read_samples(*reader, coarse, 1), expected_samples(volume, coarse, 1));
}

TEST(Verify, ReportsTheSameForAnyNumberOfThreads) {
  SampleVolume volume = make_sample({200, 140, 70}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  for (std::int64_t x = 0; x < 3; ++x) bytes[reader->brick(0, {x, 1, 0}).pieces[0].offset] ^= 2;
  const VerifyReport one = verify_bytes(bytes, 1);
  const VerifyReport four = verify_bytes(bytes, 4);
  ASSERT_EQ(one.damages.size(), 3u);
  ASSERT_EQ(four.damages.size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(one.damages[i].offset, four.damages[i].offset);
    EXPECT_EQ(one.damages[i].detail, four.damages[i].detail);
  }
}

/// Flipped bits anywhere, few damages listed, more parts than layers.
TEST(Verify, AnyNumberOfPartsReportsTheSame) {
  SampleVolume volume = make_sample({34, 20, 257}, VoxelType::uint8, Pattern::noisy_half);
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  std::mt19937 random(9);
  int damaged = 0;
  for (int round = 0; round < 24; ++round) {
    SCOPED_TRACE(round);
    std::vector<std::uint8_t> bytes = good;
    for (int flips = round % 4; flips > 0; --flips) {
      bytes[kHeaderBytes + random() % (good.size() - kHeaderBytes)] ^=
          static_cast<std::uint8_t>(1 << random() % 8);
    }
    VerifyOptions options;
    options.decode = round % 5 != 0;
    options.max_listed = static_cast<std::size_t>(round % 3);
    NoProgress progress;
    VerifyReport whole;
    try {
      whole = verify_file(byte_source_of(bytes, "sample.8vo"), options, progress);
    } catch (const Error&) {
      EXPECT_THROW(parts_of(bytes, 2, options), Error);
      continue;
    }
    damaged += whole.is_sound() ? 0 : 1;
    for (const std::int64_t count : {1, 2, 5, 40}) {
      expect_same(joined_report(parts_of(bytes, count, options), options.max_listed), whole);
    }
  }
  EXPECT_GT(damaged, 10);
}

TEST(Verify, PartsThatDoNotMakeAWholeAreRejected) {
  SampleVolume volume = make_sample({20, 20, 140}, VoxelType::uint8, Pattern::gradient);
  SampleVolume other = make_sample({20, 20, 140}, VoxelType::uint8, Pattern::noisy_half);
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto parts = parts_of(bytes, 3, {});
  VerifyOptions checksums;
  checksums.decode = false;
  const auto expect_rejected = [](std::vector<VerifiedPart> some, const std::string& words) {
    try {
      joined_report(some, 1);
      ADD_FAILURE() << words;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
      EXPECT_NE(error.detail().find(words), std::string::npos) << error.detail();
    }
  };
  expect_rejected({}, "there are none");
  expect_rejected({parts[0]}, "of 3 these are missing: 0, 1");
  expect_rejected({parts[0], parts[1], parts[1]}, "number 1 is there twice");
  expect_rejected({parts[0], parts[1], parts_of(bytes, 4, {})[3]}, "some are of 3, some of 4");
  expect_rejected({parts[0], parts[1], parts_of(bytes, 3, checksums)[2]},
                  "different files or verifications");
  expect_rejected({parts[0], parts[1], parts_of(sample_file_bytes(other), 3, {})[2]},
                  "different files or verifications");
  NoProgress progress;
  for (const WorkPart& part : {WorkPart{3, 3}, WorkPart{-1, 3}, WorkPart{0, 0},
                               WorkPart{0, WorkPart::kMostParts + 1}}) {
    EXPECT_THROW(verify_part(byte_source_of(bytes, "sample.8vo"), part, {}, progress), Error);
  }
}

TEST(Verify, ALossyFloatFileIsSoundAndTellsItsErrors) {
  SampleVolume volume = make_lossy_float_sample();
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  EXPECT_TRUE(verify_bytes(bytes).is_sound());
  const auto reader = open_bytes(bytes);
  EXPECT_EQ(reader->max_error(), 1.5);
  EXPECT_EQ(reader->achieved_error(), 0.75);
  EXPECT_EQ(reader->brick(0, {1, 0, 1}).max_error, 0.75);
  EXPECT_EQ(reader->brick(1, {0, 0, 0}).max_error, 0);
  // The voxels are what the coding makes of the codes, at every level.
  for (int level = 0; level < volume.levels.count(); ++level) {
    const Box all = box_of(volume.levels.size(level));
    const auto count = static_cast<std::size_t>(all.size().voxel_count());
    std::vector<float> voxels(count);
    reader->read(all, level, voxels.data());
    const Bytes& codes = volume.samples[static_cast<std::size_t>(level)];
    for (std::size_t i = 0; i < count; ++i) {
      ASSERT_EQ(voxels[i], static_cast<float>(codes[i] * 0.5 - 1)) << "level " << level;
    }
  }
}

TEST(Verify, BricksBehindADamagedModelOrPageAreCounted) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader header = parse_header(ByteSpan(good).first(kHeaderBytes), good.size());
  std::vector<std::uint8_t> bytes = good;
  // The first of three models stands there: that of the first layer and of the brick above.
  bytes[kHeaderBytes] ^= 1;
  VerifyReport report = verify_bytes(bytes);
  EXPECT_EQ(report.damages.front().what, "model");
  EXPECT_EQ(report.unreachable_brick_count, 6 + 1);
  bytes = good;
  bytes[header.pages.offset + 3] ^= 4;
  report = verify_bytes(bytes);
  EXPECT_EQ(report.unreachable_brick_count, 6);
}

TEST(Verify, ADamagedIndexPageIsReportedOnce) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const FileHeader header = parse_header(ByteSpan(bytes).first(kHeaderBytes), bytes.size());
  bytes[header.pages.offset + 3] ^= 4;
  const VerifyReport report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damages.front().what, "index page");
}

TEST(Verify, MetadataThatAreNoJsonObjectAreDamage) {
  for (const char* text : {"", "   ", "not json", "[1]", "null", "{\"unit\":\"\xff\xfe\"}",
                           "{} {}", "[[[[[[[[[[[[[[[[[]]]]]]]]]]]]]]]]]"}) {
    SampleVolume volume = make_sample({2, 2, 2}, VoxelType::uint8, Pattern::gradient);
    volume.description.metadata = Metadata::read(text);
    const VerifyReport report = verify_bytes(sample_file_bytes(volume));
    ASSERT_EQ(report.damage_count, 1) << text;
    EXPECT_EQ(report.damages.front().what, "metadata");
    EXPECT_FALSE(report.damages.front().is_repairable());
    EXPECT_EQ(report.damaged_brick_count, 0);
  }
}

TEST(Verify, AThumbnailOfOtherVoxelsIsFound) {
  const SampleVolume volume = make_sample({4, 4, 4}, VoxelType::uint8, Pattern::gradient);
  const auto file_with = [&](std::uint8_t voxel, const Bytes& thumbnail) {
    MemoryStorage storage;
    WriterOptions options;
    options.has_thumbnail = thumbnail.empty();
    const auto writer =
        FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1, options);
    writer->add_model({'r', 'a', 'w'});
    Bytes voxels(64, 3);
    voxels[0] = 20;
    voxels[41] = voxel;  // in the plane that is shown
    writer->add_plane_digests(digests_of_planes(voxels, 4));
    writer->add_brick(0, {{3, 20}, 3, 0, {voxels, Bytes(8, 3), Bytes(1, 3)}});
    if (!thumbnail.empty()) {
      writer->add_part({{'n', 'o', 't', 'e'}, 0, [](const auto& sink) { sink(Bytes(9)); }});
      writer->add_part({kThumbnailTag, 2, [&](const auto& sink) { sink(thumbnail); }});
    }
    writer->finish();
    return *storage.files.at("a.8vo");
  };
  const auto own = file_with(9, {});
  EXPECT_TRUE(verify_bytes(own).is_sound());
  const Bytes thumbnail = open_bytes(own)->thumbnail();
  EXPECT_TRUE(verify_bytes(file_with(9, thumbnail)).is_sound());
  const VerifyReport report = verify_bytes(file_with(3, thumbnail));
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damages.front().what, "part 'thmb'");
  EXPECT_EQ(report.damages.front().code, 1u);
  EXPECT_FALSE(report.damages.front().is_repairable());
  EXPECT_NE(report.damages.front().detail.find("part 'thmb' at byte"), std::string::npos);
}

TEST(Verify, StopsWhenAskedTo) {
  SampleVolume volume = make_sample({66, 20, 70}, VoxelType::int16, Pattern::gradient);
  const auto source = byte_source_of(sample_file_bytes(volume), "sample.8vo");
  for (int after = 0; after < 4; ++after) {
    testing::StoppingProgress progress(after);
    try {
      verify_file(source, {}, progress);
      ADD_FAILURE() << after;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
  }
}

TEST(Verify, ARangeThatLiesIsFoundByDecoding) {
  const SampleVolume volume = make_sample({4, 4, 4}, VoxelType::uint8, Pattern::gradient);
  for (const ValueRange& range : {ValueRange{3, 9}, ValueRange{2, 9}, ValueRange{3, 8}}) {
    MemoryStorage storage;
    const auto writer =
        FileWriter::create(storage, "a.8vo", volume.description, volume.levels, 1, {});
    writer->add_model({'r', 'a', 'w'});
    Bytes voxels(64, 3);
    voxels[5] = 9;
    writer->add_plane_digests(digests_of_planes(voxels, 4));
    writer->add_brick(0, {range, 3, 0, {voxels, Bytes(8, 3), Bytes(1, 3)}});
    writer->finish();
    const std::vector<std::uint8_t>& bytes = *storage.files.at("a.8vo");
    const VerifyReport report = verify_bytes(bytes);
    EXPECT_EQ(report.is_sound(), (range == ValueRange{3, 9}));
    if (!report.is_sound()) {
      EXPECT_NE(report.damages.front().detail.find("another range"), std::string::npos);
    }
    NoProgress progress;
    VerifyOptions checksums;
    checksums.decode = false;
    EXPECT_TRUE(verify_file(byte_source_of(bytes, "a.8vo"), checksums, progress).is_sound());
  }
}

// What stands in the next tier is a copy of what the bricks of a tier determine.
TEST(Verify, ATierThatIsNotMadeOfTheOneBelowIsFound) {
  SampleVolume volumes[] = {
      make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half),
      make_sample({130, 70, 129}, VoxelType::uint8, Pattern::noisy_half, VolumeKind::labels),
      make_sample({66, 20, 4098}, VoxelType::uint8, Pattern::gradient), make_lossy_float_sample()};
  for (SampleVolume& volume : volumes) {
    volume.parent_error = 1;
    const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
    const VerifyReport report = verify_bytes(bytes, 3);
    std::int64_t wrong = 0;
    for (int tier = 0; tier + 1 < volume.levels.tier_count(); ++tier) {
      wrong += volume.levels.brick_count(tier);
    }
    ASSERT_EQ(report.damage_count, wrong);
    EXPECT_EQ(report.damaged_brick_count, wrong);
    EXPECT_EQ(report.repairable_count, 0);
    const Damage& damage = report.damages.front();
    // What is named is the brick that holds the sample, not the sound one below
    const BrickEntry held = open_bytes(bytes)->brick(1, {0, 0, 0});
    EXPECT_EQ(damage.what, held.is_uniform() ? "index page" : "brick");
    EXPECT_EQ(damage.tier, 1);
    EXPECT_GE(damage.offset, kHeaderBytes);
    const std::string place = "at byte " + std::to_string(damage.offset);
    EXPECT_NE(damage.detail.find(place + ": sample 0,0,0 of level 6 is "), std::string::npos)
        << damage.detail;
    if (!held.is_uniform()) {
      EXPECT_EQ(damage.level, 6);
      EXPECT_EQ(damage.offset, held.pieces[0].offset);
    }
    // The voxels are what they are.
    const Box all = box_of(volume.levels.size(0));
    EXPECT_NO_THROW(read_samples(*open_bytes(bytes), all, 0));
  }
}

TEST(Verify, TheSamplesOfADamagedBrickOfTheNextTierAreNotCompared) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half);
  volume.parent_error = 1;
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  bytes[open_bytes(bytes)->brick(1, {0, 0, 0}).pieces[0].offset] ^= 1;
  const VerifyReport report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damages.front().tier, 1);
}

// A digest is proven by the voxels, that of the volume by those of its planes.
TEST(Verify, DigestsOfOtherVoxelsAreFound) {
  SampleVolume volume = make_sample({66, 20, 70}, VoxelType::int16, Pattern::noisy_half);
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  std::vector<std::uint8_t> bytes = good;
  bytes[bytes.size() - kTrailerBytes + 40] ^= 1;
  reseal(bytes, layout);
  VerifyReport report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_NE(report.damages.front().detail.find("voxel digest"), std::string::npos);
  EXPECT_NE(open_bytes(bytes)->voxel_digest(), open_bytes(good)->voxel_digest());

  const OpenFile file(byte_source_of(good, "sample.8vo"), {});
  SlabTrailer trailer = file.slab_trailer(1);
  trailer.plane_digests[2][0] ^= 1;  // plane 66
  const Bytes changed = encode_slab_trailer(trailer);
  bytes = good;
  std::copy(changed.begin(), changed.end(),
            bytes.begin() + static_cast<std::ptrdiff_t>(file.root().slab_trailer_offset(1)));
  reseal(bytes, layout);
  report = verify_bytes(bytes);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damages.front().what, "plane");
  EXPECT_EQ(report.damages.front().code, 66u);
}

TEST(Verify, ASlabTrailerThatLiesUnderFittingChecksumsIsFound) {
  SampleVolume volume = make_sample({130, 70, 129}, VoxelType::int16, Pattern::noisy_half);
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  const OpenFile file(byte_source_of(good, "sample.8vo"), {});
  const std::uint64_t offset = file.root().slab_trailer_offset(1);
  const std::uint32_t length = file.root().slab_trailer_bytes[1];
  const struct {
    std::function<void(SlabTrailer&)> change;
    const char* words;
  } cases[] = {
      {[](SlabTrailer& t) { t.build_id ^= 1; }, "belongs to another slab"},
      {[](SlabTrailer& t) { t.slab ^= 1; }, "belongs to another slab"},
      {[](SlabTrailer& t) { t.model ^= 1; }, "belongs to another slab"},
      {[](SlabTrailer& t) { t.lengths.back() ^= 1; }, "contradicts the index"},
      {[](SlabTrailer& t) { t.slab_crc ^= 1; }, "states another checksum of its slab"},
  };
  for (const auto& c : cases) {
    SlabTrailer trailer = parse_slab_trailer(ByteSpan(good).subspan(offset, length), 6, 64);
    c.change(trailer);
    const Bytes changed = encode_slab_trailer(trailer);
    ASSERT_EQ(changed.size(), length) << c.words;
    std::vector<std::uint8_t> bytes = good;
    std::copy(changed.begin(), changed.end(), bytes.begin() + static_cast<std::ptrdiff_t>(offset));
    reseal(bytes, layout);
    const VerifyReport report = verify_bytes(bytes);
    ASSERT_EQ(report.damage_count, 1) << c.words;
    EXPECT_EQ(report.damages.front().what, "slab trailer");
    EXPECT_EQ(report.damages.front().code, 1u);
    EXPECT_NE(report.damages.front().detail.find(c.words), std::string::npos)
        << report.damages.front().detail;
    // No voxel depends on it.
    const Box all = box_of(volume.levels.size(0));
    EXPECT_TRUE(read_samples(*open_bytes(bytes), all, 0) == volume.samples[0]);
  }
}

/// Bytes in memory whose read number `failing` ends in an io error; reads are counted.
class FailingSource final : public ByteSource {
 public:
  FailingSource(std::vector<std::uint8_t> bytes, int failing)
      : bytes_(byte_source_of(std::move(bytes), "sample.8vo")), failing_(failing) {}
  std::uint64_t size() const override { return bytes_->size(); }
  const std::string& name() const override { return bytes_->name(); }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (reads_++ == failing_) throw Error(ErrorKind::io, "the disk fails", name());
    bytes_->read(offset, out);
  }
  int reads() const { return reads_; }

 private:
  std::shared_ptr<ByteSource> bytes_;
  int failing_;
  mutable std::atomic<int> reads_ = 0;
};

TEST(Verify, AFailingDiskIsNeverReportedAsDamage) {
  // Pages above 1 MiB would be read one by one; here every read of the one tail may fail, too.
  SampleVolume volume = make_sample({66, 20, 70}, VoxelType::int16, Pattern::gradient);
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto whole = std::make_shared<FailingSource>(bytes, -1);
  NoProgress progress;
  ASSERT_TRUE(verify_file(whole, {}, progress).is_sound());
  ASSERT_GT(whole->reads(), 20);
  for (int k = 0; k < whole->reads(); ++k) {
    try {
      verify_file(std::make_shared<FailingSource>(bytes, k), {}, progress);
      ADD_FAILURE() << "read " << k << " failed unnoticed";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::io) << "read " << k << ": " << error.what();
    }
  }
}

}  // namespace
}  // namespace octavo
