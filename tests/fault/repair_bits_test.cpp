// Flipped bits turned back, or the damage rejected and nothing written.
#include "octavo/file/repair/repair_bits.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "fault/reseal.h"
#include "octavo/core/error.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/layout.h"
#include "octavo/file/open_file.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;
using FileContent = std::vector<std::uint8_t>;

struct Outcome {
  std::size_t flip_count = 0;
  std::string failure;
  std::string field;
  ErrorKind kind = ErrorKind::internal;
};

Outcome repair(MemoryStorage& storage) {
  Outcome outcome;
  NoProgress progress;
  try {
    const BitRepairOptions options{.overwrite = true, .for_each = {}, .make_hasher = {}};
    outcome.flip_count = repair_bits(storage, "bad.8vo", "out.8vo", options, progress).flips.size();
  } catch (const Error& error) {
    outcome.failure = error.what();
    outcome.kind = error.kind();
    outcome.field = error.field();
  }
  return outcome;
}

void put(MemoryStorage& storage, const std::string& name, FileContent bytes) {
  storage.files[name] = std::make_shared<FileContent>(std::move(bytes));
}

// `bad` becomes `good` by turning back `flip_count` bits.
void expect_repaired(const FileContent& bad, const FileContent& good, std::size_t flip_count) {
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  const Outcome outcome = repair(storage);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.flip_count, flip_count);
  EXPECT_TRUE(*storage.files.at("out.8vo") == good);
}

FileContent two_tiers() {
  SampleVolume volume = make_sample({66, 12, 70}, VoxelType::uint8, Pattern::noisy_half);
  volume.model_layers = 2;
  return sample_file_bytes(volume);
}

// A file of one grey brick of noise, either stored or with a segment for each level.
FileContent noise_brick(const Size3& size, VoxelType type, bool is_stored) {
  SampleVolume volume = make_sample(size, type, Pattern::gradient);
  std::mt19937 random(7);
  for (std::uint8_t& byte : volume.samples[0]) byte = static_cast<std::uint8_t>(random());
  MemoryStorage storage;
  if (!is_stored) return sample_file_bytes(volume);
  const auto writer =
      FileWriter::create(storage, "sample.8vo", volume.description, volume.levels, 1, {});
  writer->add_model({'r', 'a', 'w'});
  EncodedBrick brick;
  const auto [low, high] = std::minmax_element(volume.samples[0].begin(), volume.samples[0].end());
  brick.range = {*low, *high};
  brick.segments.resize(static_cast<std::size_t>(volume.levels.count()));
  brick.segments[0] = volume.samples[0];
  writer->add_plane_digests(sample_plane_digests(volume, 0));
  writer->add_brick(0, brick);
  writer->finish();
  return *storage.files.at("sample.8vo");
}

// A file with a part of that tag and text.
FileContent with_part(const PartTag& tag, const std::string& text) {
  SampleVolume volume = make_sample({2, 2, 2}, VoxelType::uint8, Pattern::gradient);
  MemoryStorage storage;
  const auto writer =
      FileWriter::create(storage, "sample.8vo", volume.description, volume.levels, 1, {});
  encode_sample(*writer, volume);
  writer->add_part({tag, 0, [text](const std::function<void(ByteSpan)>& sink) {
                      sink({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
                    }});
  writer->finish();
  return *storage.files.at("sample.8vo");
}

BrickEntry::StoredPiece finest_segment(const FileContent& file) {
  return open_bytes(file)->brick(0, {0, 0, 0}).pieces[0];
}

// Random bytes in [begin, end) that no CRC-32C tells from those before: sums of its polynomial, at
// any place. One bit more, and they pass for that flipped bit.
void garble_unseen(FileContent& file, std::uint64_t begin, std::uint64_t end) {
  constexpr std::uint64_t kPolynomial = std::uint64_t{0x82f63b78} << 1 | 1;
  constexpr std::uint64_t kPolynomialBytes = 5;
  std::mt19937 random(11);
  for (std::uint64_t at = begin; at + kPolynomialBytes <= end; ++at) {
    if (random() % 2 == 0) continue;
    for (std::uint64_t i = 0; i < kPolynomialBytes; ++i) {
      file[at + i] ^= static_cast<std::uint8_t>(kPolynomial >> 8 * i);
    }
  }
}

TEST(RepairBits, AnyFlippedBitIsTurnedBack) {
  SampleVolume small = make_sample({16, 16, 4}, VoxelType::uint8, Pattern::noisy_half);
  const FileContent files[] = {sample_file_bytes(small), two_tiers()};
  for (const FileContent& good : files) {
    const std::size_t step = good.size() < 3000 ? 3 : 271;
    for (std::size_t bit = 0; bit < 8 * good.size(); bit += step) {
      FileContent bad = good;
      bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      MemoryStorage storage;
      put(storage, "bad.8vo", bad);
      const Outcome outcome = repair(storage);
      ASSERT_EQ(outcome.failure, "") << "byte " << bit / 8;
      ASSERT_TRUE(*storage.files.at("out.8vo") == good) << "byte " << bit / 8;
      ASSERT_TRUE(*storage.files.at("bad.8vo") == bad);
      ASSERT_EQ(storage.files.size(), 2u);
    }
  }
}

TEST(RepairBits, AGrowingFileIsRejectedAsSuch) {
  const FileContent good = two_tiers();
  HeaderBlock block{};
  std::copy_n(good.begin(), block.size(), block.begin());
  block = encode_header(parse_unsealed_header(block));
  for (const std::size_t length : {std::size_t{kHeaderBytes}, good.size() / 2}) {
    FileContent growing(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length));
    std::copy(block.begin(), block.end(), growing.begin());
    MemoryStorage storage;
    put(storage, "bad.8vo", growing);
    const Outcome outcome = repair(storage);
    EXPECT_EQ(outcome.kind, ErrorKind::corrupt);
    EXPECT_NE(outcome.failure.find("bad.8vo: not sealed"), std::string::npos) << outcome.failure;
    EXPECT_NE(outcome.failure.find("build it again"), std::string::npos) << outcome.failure;
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

TEST(RepairBits, OneFlippedBitInEachOfSeveralPiecesIsTurnedBack) {
  const FileContent good = two_tiers();
  FileContent bad = good;
  // The header, a segment, the trailer.
  for (const std::size_t byte : {std::size_t{60}, std::size_t{512} + 900, good.size() - 20}) {
    bad[byte] ^= 32;
  }
  expect_repaired(bad, good, 3);
}

// Of 8-bit voxels that are stored, 512 are repaired and no more; of coded bytes 128 KiB.
TEST(RepairBits, AFlippedBitIsTurnedBackWhereOtherDamageHardlyPassesForOne) {
  const struct {
    Size3 size;
    VoxelType type;
    bool is_stored;
    bool is_repaired;
  } cases[] = {
      {{16, 16, 2}, VoxelType::uint8, true, true},   {{16, 16, 3}, VoxelType::uint8, true, false},
      {{32, 32, 32}, VoxelType::uint8, true, false}, {{16, 16, 3}, VoxelType::uint8, false, true},
      {{64, 64, 16}, VoxelType::int16, false, true}, {{64, 64, 17}, VoxelType::int16, false, false},
  };
  for (const auto& c : cases) {
    const FileContent good = noise_brick(c.size, c.type, c.is_stored);
    const BrickEntry::StoredPiece segment = finest_segment(good);
    FileContent bad = good;
    bad[segment.offset + segment.length / 3] ^= 16;
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    const Outcome outcome = repair(storage);
    SCOPED_TRACE(std::to_string(segment.length) + " bytes: " + outcome.failure);
    EXPECT_EQ(outcome.flip_count, c.is_repaired ? 1u : 0u);
    EXPECT_EQ(storage.files.size(), c.is_repaired ? 2u : 1u);
    if (c.is_repaired) {
      EXPECT_TRUE(*storage.files.at("out.8vo") == good);
      continue;
    }
    EXPECT_EQ(outcome.kind, ErrorKind::corrupt);
    EXPECT_NE(outcome.failure.find("one flipped bit would explain it, but so would other damage"),
              std::string::npos);
    EXPECT_EQ(outcome.field, "repair.salvage");
  }
}

TEST(RepairBits, ABitOfAPartIsNotTurnedBackAsNothingElseProvesIt) {
  for (const PartTag& tag : {PartTag{'n', 'o', 't', 'e'}, PartTag{'X', 'y', 'z', '9'}}) {
    const FileContent good = with_part(tag, "some bytes");
    FileContent bad = good;
    bad[header_of(good).pages.end() + 1] ^= 4;
    NoProgress progress;
    const VerifyReport report = verify_file(byte_source_of(bad, "bad.8vo"), {}, progress);
    ASSERT_EQ(report.damage_count, 1);
    EXPECT_TRUE(report.damages.front().flipped_byte.has_value());
    EXPECT_EQ(report.repairable_count, 0);
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    const Outcome outcome = repair(storage);
    EXPECT_EQ(outcome.kind, ErrorKind::corrupt);
    EXPECT_NE(outcome.failure.find("nothing else proves these bytes"), std::string::npos)
        << outcome.failure;
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

TEST(RepairBits, AGarbledSectorThatPassesForOneFlippedBitIsRejected) {
  constexpr std::uint64_t kSectorBytes = 512;
  const FileContent good = noise_brick({32, 32, 32}, VoxelType::uint8, true);
  const BrickEntry::StoredPiece segment = finest_segment(good);
  FileContent bad = good;
  const std::uint64_t sector = (segment.offset / kSectorBytes + 8) * kSectorBytes;
  garble_unseen(bad, sector, sector + kSectorBytes);
  ASSERT_NO_THROW(read_samples(*open_bytes(bad), {{0, 0, 0}, {32, 32, 32}}, 0));
  bad[segment.offset + 77] ^= 2;
  NoProgress progress;
  const VerifyReport report = verify_file(byte_source_of(bad, "bad.8vo"), {}, progress);
  ASSERT_EQ(report.damage_count, 1);
  EXPECT_EQ(report.damages.front().flipped_byte, segment.offset + 77);
  EXPECT_EQ(report.repairable_count, 0);
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  EXPECT_EQ(repair(storage).kind, ErrorKind::corrupt);
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(RepairBits, FlippedBitsBehindOthersAreTurnedBackAsWell) {
  const FileContent good = two_tiers();
  const OpenFile file(byte_source_of(good, "good.8vo"), {});
  const BrickEntry entry = file.entry_at(0, {1, 0, 1});
  const auto page = static_cast<std::size_t>(file.root().tiers[0].layer_pages);
  FileContent bad = good;
  bad[file.header().root.offset + 3] ^= 1;
  bad[file.root().tiers[0].pages[page].offset + 2] ^= 4;
  bad[file.model_piece(entry.model).offset] ^= 8;
  bad[entry.pieces[0].offset + 5] ^= 16;
  expect_repaired(bad, good, 4);

  // What cannot be repaired is named, not what hid it.
  bad[entry.pieces[0].offset + 6] ^= 16;
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  const Outcome rejected = repair(storage);
  EXPECT_EQ(rejected.kind, ErrorKind::corrupt);
  EXPECT_NE(rejected.failure.find("bad.8vo: brick o-code"), std::string::npos) << rejected.failure;
  EXPECT_NE(rejected.failure.find("more than one flipped bit"), std::string::npos);
  EXPECT_EQ(rejected.failure.find("(one flipped bit"), std::string::npos) << rejected.failure;
}

TEST(RepairBits, MoreFlippedBitsThanVerifyDescribesAreTurnedBack) {
  SampleVolume volume = make_sample({34 * 64, 33 * 64, 1}, VoxelType::uint8, Pattern::noisy_half);
  const FileContent good = sample_file_bytes(volume);
  const OpenFile file(byte_source_of(good, "good.8vo"), {});
  FileContent bad = good;
  std::size_t flip_count = 0;
  for (Index3 brick; brick.y < 33; ++brick.y) {
    for (brick.x = 0; brick.x < 34; ++brick.x, ++flip_count) {
      bad[file.entry_at(0, brick).pieces[0].offset] ^= 1;
    }
  }
  NoProgress progress;
  const VerifyReport report = verify_file(byte_source_of(bad, "bad.8vo"), {}, progress);
  EXPECT_EQ(report.damages.size(), VerifyOptions().max_listed);
  EXPECT_EQ(report.repairable_count, static_cast<std::int64_t>(flip_count));
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  EXPECT_EQ(repair(storage).flip_count, flip_count);
  EXPECT_TRUE(*storage.files.at("out.8vo") == good);
}

TEST(RepairBits, MetadataAreRepairedToTextOnly) {
  SampleVolume volume = make_sample({16, 16, 4}, VoxelType::uint8, Pattern::noisy_half);
  volume.description.metadata =
      Metadata::read(R"({"text":")" + std::string(700, 'a') + "\u00e4\"}");
  const FileContent good = sample_file_bytes(volume);
  MemoryStorage storage;
  put(storage, "bad.8vo", good);
  const OpenFile file(open_byte_source(storage, "bad.8vo"), {});
  const Section metadata = file.header().metadata;
  FileContent bad = good;
  bad[metadata.offset + 600] ^= 4;
  put(storage, "bad.8vo", bad);
  EXPECT_EQ(repair(storage).flip_count, 1u);
  EXPECT_TRUE(*storage.files.at("out.8vo") == good);
  storage.files.erase("out.8vo");
  garble_unseen(bad, metadata.offset + 20, metadata.offset + 500);
  put(storage, "bad.8vo", bad);
  EXPECT_EQ(repair(storage).kind, ErrorKind::corrupt);
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(RepairBits, WorseDamageIsRejectedAndNothingIsWritten) {
  const FileContent good = two_tiers();
  const std::size_t places[] = {100, 700, good.size() / 2, good.size() - 102};
  for (const std::size_t place : places) {
    FileContent bad = good;
    for (std::size_t i = 0; i < 4; ++i) bad[place + i] = static_cast<std::uint8_t>(~bad[place + i]);
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    put(storage, "out.8vo", {'o', 'l', 'd'});
    EXPECT_EQ(repair(storage).kind, ErrorKind::corrupt) << place;
    EXPECT_EQ(storage.files.size(), 2u);
    EXPECT_EQ(*storage.files.at("out.8vo"), (FileContent{'o', 'l', 'd'}));
  }
}

TEST(RepairBits, ATrailerIsMadeAnewWhateverItsDamage) {
  const FileContent good = two_tiers();
  FileContent bad = good;
  std::fill(bad.end() - kTrailerBytes, bad.end(), std::uint8_t{0xa5});
  bad[700] ^= 1;
  NoProgress progress;
  EXPECT_THROW(verify_file(byte_source_of(bad, "bad.8vo"), {}, progress), Error);
  EXPECT_TRUE(opens_repaired(byte_source_of(bad, "bad.8vo")));
  expect_repaired(bad, good, 1);
  // It vouches for nothing: every other damage is found without it.
  MemoryStorage storage;
  bad[701] ^= 1;
  put(storage, "bad.8vo", bad);
  EXPECT_EQ(repair(storage).kind, ErrorKind::corrupt);
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(RepairBits, AWholeTrailerOfAnotherFileIsRejected) {
  SampleVolume other = make_sample({66, 12, 70}, VoxelType::uint8, Pattern::gradient);
  const FileContent from = sample_file_bytes(other);
  FileContent bad = two_tiers();
  std::copy(from.end() - kTrailerBytes, from.end(), bad.end() - kTrailerBytes);
  MemoryStorage storage;
  put(storage, "bad.8vo", bad);
  const Outcome outcome = repair(storage);
  EXPECT_NE(outcome.failure.find("trailer does not belong to the header"), std::string::npos)
      << outcome.failure;
  EXPECT_FALSE(opens_repaired(byte_source_of(bad, "bad.8vo")));
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(RepairBits, BytesBehindTheEndAreLeftOut) {
  const FileContent good = two_tiers();
  for (const bool has_flips : {false, true}) {
    FileContent bad = good;
    if (has_flips) bad[100] ^= 2;
    if (has_flips) bad[good.size() - 9] ^= 2;
    bad.insert(bad.end(), 1000, std::uint8_t{7});
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    NoProgress progress;
    const BitRepairResult result = repair_bits(storage, "bad.8vo", "out.8vo", {}, progress);
    EXPECT_EQ(result.dropped_bytes, 1000u);
    EXPECT_EQ(result.file_bytes, good.size());
    EXPECT_EQ(result.flips.size(), has_flips ? 2u : 0u);
    EXPECT_FALSE(result.has_new_trailer);
    EXPECT_TRUE(*storage.files.at("out.8vo") == good);
  }
}

TEST(RepairBits, WhatIsRejectedIsNamed) {
  const FileContent good = two_tiers();
  FileContent long_and_damaged = good;
  long_and_damaged.resize(good.size() + 9);
  long_and_damaged[60] ^= 0xff;
  FileContent bad_root = good;
  bad_root[good.size() - 102] ^= 0x3;
  for (const FileContent& bad : {long_and_damaged, bad_root, FileContent(100), FileContent{}}) {
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    const Outcome outcome = repair(storage);
    EXPECT_TRUE(outcome.failure.starts_with("bad.8vo: ")) << outcome.failure;
    EXPECT_FALSE(opens_repaired(byte_source_of(bad, "bad.8vo")));
  }
}

TEST(RepairBits, ACutFileIsRejected) {
  const FileContent good = two_tiers();
  for (const std::size_t length :
       {std::size_t{0}, std::size_t{100}, std::size_t{600}, good.size() / 2, good.size() - 1}) {
    MemoryStorage storage;
    put(storage, "bad.8vo", {good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)});
    const Outcome outcome = repair(storage);
    EXPECT_TRUE(outcome.kind == ErrorKind::truncated || outcome.kind == ErrorKind::not_octavo)
        << outcome.failure;
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

TEST(RepairBits, OfASoundFileNothingIsWritten) {
  MemoryStorage storage;
  put(storage, "bad.8vo", two_tiers());
  const Outcome outcome = repair(storage);
  EXPECT_EQ(outcome.failure, "");
  EXPECT_EQ(outcome.flip_count, 0u);
  EXPECT_EQ(storage.files.size(), 1u);
}

TEST(RepairBits, AnExistingFileIsKeptUnlessAskedForAlsoOneThatAppearsMeanwhile) {
  FileContent bad = two_tiers();
  bad[1000] ^= 1;
  const auto repair_into = [&](MemoryStorage& storage) {
    put(storage, "bad.8vo", bad);
    NoProgress progress;
    repair_bits(storage, "bad.8vo", "out.8vo", {}, progress);
  };
  MemoryStorage empty;
  repair_into(empty);
  EXPECT_EQ(*empty.files.at("out.8vo"), two_tiers());
  for (const bool is_there_before : {true, false}) {
    MemoryStorage storage;
    if (is_there_before) put(storage, "out.8vo", {'o', 'l', 'd'});
    storage.meanwhile = [&](const std::string& what) {
      if (what == "sync") put(storage, "out.8vo", {'o', 'l', 'd'});
    };
    EXPECT_THROW(repair_into(storage), Error);
    EXPECT_EQ(storage.files.at("out.8vo")->size(), 3u);
    EXPECT_EQ(storage.files.size(), 2u);
  }
}

TEST(RepairBits, EveryFailingCallLeavesTheOldFile) {
  const FileContent good = two_tiers();
  FileContent bad = good;
  bad[1000] ^= 1;
  for (std::size_t k = 1;; ++k) {
    MemoryStorage storage;
    storage.fail_at = k;
    put(storage, "bad.8vo", bad);
    put(storage, "out.8vo", {'o', 'l', 'd'});
    const Outcome outcome = repair(storage);
    ASSERT_EQ(storage.files.size(), 2u) << outcome.failure;
    if (!storage.has_failed) {
      EXPECT_GT(k, 10u);
      EXPECT_EQ(outcome.failure, "");
      break;
    }
    ASSERT_NE(outcome.failure, "") << "call " << k << " failed unnoticed";
    const FileContent& now = *storage.files.at("out.8vo");
    EXPECT_TRUE(storage.calls.back() == "sync_folder" ? now == good : now.size() == 3);
  }
}

TEST(RepairBits, EveryFailingCallLeavesNothingAndNamesTheFileThatWasAskedFor) {
  FileContent bad = two_tiers();
  bad[1000] ^= 1;
  for (std::size_t k = 1;; ++k) {
    std::string said;
    for (const bool is_dying : {false, true}) {
      MemoryStorage storage;
      storage.fail_at = k;
      storage.is_dying = is_dying;
      put(storage, "bad.8vo", bad);
      const Outcome outcome = repair(storage);
      if (!storage.has_failed) {
        EXPECT_GT(k, 10u);
        return;
      }
      EXPECT_EQ(outcome.kind, ErrorKind::io);
      EXPECT_EQ(outcome.failure.find("tmp"), std::string::npos) << outcome.failure;
      // Where removing fails as well, the first failure is reported.
      if (is_dying) {
        EXPECT_EQ(outcome.failure, said);
      } else {
        EXPECT_EQ(storage.files.size(), 1u) << outcome.failure;
        said = outcome.failure;
      }
    }
  }
}

// Asks to stop as soon as some work has begun.
class StopsInWork final : public Progress {
 public:
  explicit StopsInWork(std::string_view work) : work_(work) {}
  void begin(std::string_view what, std::int64_t, std::string_view) override {
    has_begun_ = has_begun_ || what == work_;
  }
  void advance(std::int64_t) override { is_cancelled_ = has_begun_; }
  void end() override {}
  bool is_cancelled() const override { return is_cancelled_; }

 private:
  std::string_view work_;
  bool has_begun_ = false;
  bool is_cancelled_ = false;
};

TEST(RepairBits, StopsBehindTheNextBlockAndLeavesNothing) {
  SampleVolume volume = make_sample({64 * 30, 64 * 30, 1}, VoxelType::uint8, Pattern::noisy_half);
  FileContent bad = sample_file_bytes(volume);
  bad[1000] ^= 1;
  for (const std::string_view work : {"verifying", "writing"}) {
    MemoryStorage storage;
    put(storage, "bad.8vo", bad);
    StopsInWork progress(work);
    try {
      repair_bits(storage, "bad.8vo", "out.8vo", {}, progress);
      ADD_FAILURE() << "not stopped while " << work;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::cancelled);
    }
    EXPECT_EQ(std::ranges::count(storage.calls, "write"), work == "writing" ? 1 : 0);
    EXPECT_EQ(storage.files.size(), 1u);
  }
}

}  // namespace
}  // namespace octavo
