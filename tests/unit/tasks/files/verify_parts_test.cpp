#include "octavo/tasks/files/verify_parts.h"

#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "octavo/core/error.h"
#include "octavo/tasks/files/part_result.h"
#include "support/scan_files.h"

namespace octavo {
namespace {

class VerifyParts : public testing::ScanFiles {
 protected:
  void SetUp() override { input_ = write_grey("scan.8vo"); }

  /// What so many parts find, in files.
  std::vector<std::string> found_by(std::int64_t count) {
    std::vector<std::string> paths;
    for (std::int64_t number = 0; number < count; ++number) {
      paths.push_back(folder_.file("found-" + std::to_string(number)));
      verify_volume_part({input_, {number, count}, {paths.back(), true}}, context_);
    }
    return paths;
  }

  std::string input_;
};

TEST_F(VerifyParts, SayTogetherThatAFileIsSound) {
  const VerifyVolumeResult whole = verify_volume({input_, {}, {}}, context_);
  const VerifyVolumeResult joined = join_verified({input_, found_by(3)}, context_);
  EXPECT_TRUE(joined.report.is_sound());
  EXPECT_EQ(joined.report.brick_count, whole.report.brick_count);
  EXPECT_EQ(joined.report.piece_count, whole.report.piece_count);
  EXPECT_EQ(joined.report.file_bytes, whole.report.file_bytes);
  EXPECT_EQ(joined.volume.size, kScanSize);
}

TEST_F(VerifyParts, KeepEveryDamageAsItIs) {
  const std::uint64_t brick = brick_offset(input_);
  damage(input_, brick, 4);
  damage(input_, brick + 60, 0x55);
  const VerifyReport whole = verify_volume({input_, {}, {}}, context_).report;
  const VerifyReport joined = join_verified({input_, found_by(2)}, context_).report;
  ASSERT_GE(whole.damage_count, 1);
  EXPECT_EQ(joined.damage_count, whole.damage_count);
  EXPECT_EQ(joined.repairable_count, whole.repairable_count);
  EXPECT_EQ(joined.damaged_brick_count, whole.damaged_brick_count);
  ASSERT_EQ(joined.damages.size(), whole.damages.size());
  for (std::size_t i = 0; i < whole.damages.size(); ++i) {
    const Damage& a = joined.damages[i];
    const Damage& b = whole.damages[i];
    EXPECT_EQ(a.what, b.what);
    EXPECT_EQ(a.detail, b.detail);
    EXPECT_EQ(a.tier, b.tier);
    EXPECT_EQ(a.level, b.level);
    EXPECT_EQ(a.brick, b.brick);
    EXPECT_EQ(a.code, b.code);
    EXPECT_EQ(a.offset, b.offset);
    EXPECT_EQ(a.length, b.length);
    EXPECT_EQ(a.stored, b.stored);
    EXPECT_EQ(a.found, b.found);
    EXPECT_EQ(a.flipped_byte, b.flipped_byte);
    EXPECT_EQ(a.flipped_bit, b.flipped_bit);
    EXPECT_EQ(a.proof, b.proof);
  }
}

TEST_F(VerifyParts, OfAnotherFileAreRejected) {
  const std::vector<std::string> found = found_by(2);
  voxels_[5] = static_cast<std::int16_t>(voxels_[5] + 1);
  const std::string other = write_grey("other.8vo");
  const Failure failure = failure_of([&] { join_verified({other, found}, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find("is of another file than"), std::string::npos);
}

/// What was found in a file says nothing of a copy, whose bytes may have come otherwise.
TEST_F(VerifyParts, OfTheFileThatACopyWasMadeOfAreRejected) {
  const std::vector<std::string> found = found_by(2);
  const std::string copy = folder_.file("copy.8vo");
  std::filesystem::copy_file(input_, copy);
  std::filesystem::last_write_time(
      copy, std::filesystem::last_write_time(input_) + std::chrono::seconds(1));
  damage(copy, brick_offset(copy) + 60, 0x55);
  const Failure failure = failure_of([&] { join_verified({copy, found}, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::invalid_argument);
  EXPECT_NE(failure.detail.find("or of an earlier state"), std::string::npos);
}

TEST_F(VerifyParts, AFileOfOtherNumbersIsNamed) {
  const std::vector<std::string> found = found_by(2);
  const FoundPart whole = read_part_result(found[1], "verify", context_);
  for (const char* const name : {"counts", "written_ns", "voxel_digest"}) {
    std::vector<JsonObject> lines = whole.lines;
    lines.front().set(name, std::vector<std::int64_t>{});
    write_part_result({found[1], true}, "verify", whole.part, lines);
    try {
      join_verified({input_, found}, context_);
      ADD_FAILURE() << name;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::corrupt) << error.what();
      EXPECT_EQ(error.path(), found[1]) << error.what();
    }
  }
}

/// Any changed byte, any end that is missing.
TEST_F(VerifyParts, FilesThatWereChangedAreRejected) {
  const std::vector<std::string> found = found_by(1);
  std::ifstream in(found.front(), std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(in), {}};
  ASSERT_GT(whole.size(), 200u);
  const auto expect_corrupt = [&](const std::string& text) {
    std::ofstream(found.front(), std::ios::binary) << text;
    EXPECT_EQ(failure_of([&] { join_verified({input_, found}, context_); }).kind,
              ErrorKind::corrupt);
  };
  for (std::size_t at = 0; at < whole.size(); at += 23) {
    std::string text = whole;
    text[at] = static_cast<char>(text[at] ^ 1);
    expect_corrupt(text);
    expect_corrupt(whole.substr(0, at));
  }
}

TEST_F(VerifyParts, AnExistingOutputIsKept) {
  const std::vector<std::string> found = found_by(1);
  const Failure failure =
      failure_of([&] { verify_volume_part({input_, {0, 1}, {found.front(), false}}, context_); });
  EXPECT_EQ(failure.kind, ErrorKind::io);
  EXPECT_EQ(failure.field, "output.overwrite");
}

}  // namespace
}  // namespace octavo
