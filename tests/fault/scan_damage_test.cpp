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
#include "support/brick_pieces.h"

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

  bool is_rejected(const Box& box, int level) const {
    try {
      read_box(*FileReader::open(source()), box, level);
    } catch (const Error& error) {
      return error.kind() == ErrorKind::corrupt;
    }
    return false;
  }

  std::string bytes_;
  std::mt19937_64 random_{31};
};

TEST_F(ScanDamage, EveryFlippedBitIsFound) {
  GoalCases goal("B1", "flipped bits of the CT head found", case_count(150, 1'000'000));
  while (goal.next()) {
    const std::uint64_t bit = random_() % (8 * bytes_.size());
    flip(bit);
    ASSERT_TRUE(is_noticed()) << "bit " << bit;
    flip(bit);
  }
}

TEST_F(ScanDamage, ABrickWithAFlippedBitIsRejectedAndAllOthersAreRead) {
  const auto whole = FileReader::open(source());
  const std::vector<BrickPiece> pieces = pieces_of(*whole);
  ASSERT_GT(pieces.size(), 100U);
  const auto box_of_brick = [&](const BrickPiece& stored) {
    return brick_box_at(whole->levels(), stored.level, stored.entry.brick);
  };
  GoalCases goal("B1", "partial reads of a flipped bit rejected", case_count(20, 100'000));
  while (goal.next()) {
    const BrickPiece& hit = pieces[random_() % pieces.size()];
    const BrickPiece& other = pieces[random_() % pieces.size()];
    const std::uint64_t bit = 8 * hit.piece.offset + random_() % (8 * hit.piece.length);
    flip(bit);
    ASSERT_TRUE(is_rejected(box_of_brick(hit), hit.level)) << "bit " << bit;
    if (other.entry.tier != hit.entry.tier || other.entry.brick != hit.entry.brick) {
      const Box box = box_of_brick(other);
      ASSERT_TRUE(read_box(*FileReader::open(source()), box, other.level) ==
                  read_box(*whole, box, other.level))
          << "bit " << bit;
    }
    flip(bit);
  }
}

TEST_F(ScanDamage, EveryShortenedFileIsRejected) {
  GoalCases goal("B2", "lengths of the CT head rejected", case_count(1000, 10'000));
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
