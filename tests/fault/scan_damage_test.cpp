// Flipped bits and lost ends of the file of a whole scan.
// Few of the cases in the everyday run, all of them under tools/nightly.
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>

#include "octavo/core/error.h"
#include "octavo/file/verify.h"
#include "octavo/io/open_source.h"
#include "support/ct_head.h"
#include "support/goal_cases.h"

namespace octavo::testing {
namespace {

/// A source over bytes that the test changes.
class SharedBytes final : public ByteSource {
 public:
  explicit SharedBytes(const std::string& bytes) : bytes_(bytes) {}
  std::uint64_t size() const override { return length_; }
  const std::string& name() const override { return name_; }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    if (offset > length_ || out.size() > length_ - offset) {
      throw Error(ErrorKind::truncated, "the bytes end before", name_, offset);
    }
    std::memcpy(out.data(), bytes_.data() + offset, out.size());
  }
  void shorten(std::uint64_t length) { length_ = length; }

 private:
  const std::string& bytes_;
  std::uint64_t length_ = bytes_.size();
  std::string name_ = "scan.8vo";
};

/// Bytes of a file that one brick needs at one level.
struct Segment {
  int tier = 0;
  Index3 brick;
  int level = 0;
  Box box;  ///< of the brick, at that level
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
};

void append_segments(const Levels& levels, const BrickEntry& entry,
                     std::vector<Segment>& segments) {
  for (std::size_t i = 0; i < entry.segments.size(); ++i) {
    const auto& [offset, length, crc] = entry.segments[i];
    if (length == 0) continue;
    const int level = Levels::first_level(entry.tier) + static_cast<int>(i);
    const Size3 side = brick_side_at(levels, level);
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
      box.lo[axis] = entry.brick[axis] * side[axis];
      box.hi[axis] = std::min(box.lo[axis] + side[axis], levels.size(level)[axis]);
    }
    segments.push_back({entry.tier, entry.brick, level, box, offset, length});
  }
}

std::vector<Segment> segments_of(const FileReader& reader) {
  std::vector<Segment> segments;
  const Levels& levels = reader.levels();
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    const Size3 grid = levels.brick_grid(tier);
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const Index3 brick{i % grid.x, i / grid.x % grid.y, i / (grid.x * grid.y)};
      append_segments(levels, reader.brick(tier, brick), segments);
    }
  }
  return segments;
}

/// The CT head as a file; nothing when it is not here.
std::string head_file_bytes() {
  const ScratchFolder folder;
  const auto header = ct_head_in(folder);
  if (!header) return {};
  const auto source = open_source({*header}, {});
  NoProgress progress;
  build_file(*source, local_storage(), folder.file("head.8vo"), {}, progress);
  return bytes_of_file(folder.file("head.8vo"));
}

class ScanDamage : public ::testing::Test {
 protected:
  void SetUp() override {
    static const std::string whole = head_file_bytes();
    if (whole.empty()) GTEST_SKIP() << kMissingCtHead;
    bytes_ = whole;
  }

  std::shared_ptr<SharedBytes> source() const { return std::make_shared<SharedBytes>(bytes_); }

  void flip(std::uint64_t bit) { bytes_[bit / 8] ^= static_cast<char>(1 << bit % 8); }

  bool is_noticed() const {
    NoProgress progress;
    try {
      return !verify_file(source(), {.decode = false, .for_each = {}}, progress).is_sound();
    } catch (const Error& error) {
      return error.kind() != ErrorKind::internal;
    }
  }

  /// Whether reading the voxels of a segment is refused.
  bool is_refused(const Segment& segment) const {
    try {
      read_box(*FileReader::open(source()), segment.box, segment.level);
    } catch (const Error& error) {
      return error.kind() == ErrorKind::corrupt;
    }
    return false;
  }

  std::string bytes_;
  std::mt19937_64 random_{31};
};

TEST_F(ScanDamage, EveryFlippedBitIsFound) {
  GoalCases goal("B1", "flipped bits of the CT head found", case_count(500, 1'000'000));
  while (goal.next()) {
    const std::uint64_t bit = random_() % (8 * bytes_.size());
    flip(bit);
    ASSERT_TRUE(is_noticed()) << "bit " << bit;
    flip(bit);
  }
}

TEST_F(ScanDamage, ABrickWithAFlippedBitIsRefusedAndAllOthersAreRead) {
  const auto whole = FileReader::open(source());
  const std::vector<Segment> segments = segments_of(*whole);
  ASSERT_GT(segments.size(), 100U);
  GoalCases goal("B1", "partial reads of a flipped bit refused", case_count(50, 100'000));
  while (goal.next()) {
    const Segment& hit = segments[random_() % segments.size()];
    const Segment& other = segments[random_() % segments.size()];
    const bool is_other_brick = other.tier != hit.tier || other.brick != hit.brick;
    const std::uint64_t bit = 8 * hit.offset + random_() % (8 * hit.length);
    flip(bit);
    ASSERT_TRUE(is_refused(hit)) << "bit " << bit;
    if (is_other_brick) {
      ASSERT_TRUE(read_box(*FileReader::open(source()), other.box, other.level) ==
                  read_box(*whole, other.box, other.level))
          << "bit " << bit;
    }
    flip(bit);
  }
}

TEST_F(ScanDamage, EveryShortenedFileIsRefused) {
  GoalCases goal("B2", "lengths of the CT head refused", case_count(1000, 10'000));
  while (goal.next()) {
    const std::uint64_t length = 1 + random_() % (bytes_.size() - 1);
    const auto shortened = source();
    shortened->shorten(length);
    try {
      FileReader::open(shortened);
      FAIL() << "opened at length " << length;
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::truncated) << "length " << length;
    }
  }
}

}  // namespace
}  // namespace octavo::testing
