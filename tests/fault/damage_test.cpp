#include <gtest/gtest.h>

#include <random>

#include "octavo/file/pieces.h"
#include "octavo/file/verify.h"
#include "support/goal_cases.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

// What became of a damaged file: rejected, found damaged, or not noticed.
bool is_noticed_by_verify(const std::vector<std::uint8_t>& bytes) {
  NoProgress progress;
  try {
    return !verify_file(byte_source_of(bytes, "damaged.8vo"), {}, progress).is_sound();
  } catch (const Error&) {
    return true;
  }
}

// Levels whose samples came back, but wrong.
int wrong_levels(const std::vector<std::uint8_t>& bytes, const SampleVolume& volume) {
  int wrong = 0;
  try {
    const auto reader = open_bytes(bytes);
    for (int level = 0; level < volume.levels.count(); ++level) {
      const Box all = box_of(volume.levels.size(level));
      try {
        wrong += read_samples(*reader, all, level) != expected_samples(volume, all, level);
      } catch (const Error&) {
        continue;
      }
    }
  } catch (const Error&) {
    return 0;
  }
  return wrong;
}

struct Damaged {
  std::string name;
  SampleVolume volume;
};

std::vector<Damaged> small_files() {
  return {{"single voxel", make_sample({1, 1, 1}, VoxelType::uint8, Pattern::constant)},
          {"grey 16^3", make_sample({16, 16, 16}, VoxelType::uint8, Pattern::noisy_half)},
          {"grey 8x8x2", make_sample({8, 8, 2}, VoxelType::int16, Pattern::gradient)},
          {"labels 16^3",
           make_sample({16, 16, 16}, VoxelType::uint16, Pattern::noisy_half, VolumeKind::labels)},
          {"two tiers", make_sample({66, 2, 3}, VoxelType::uint8, Pattern::gradient)}};
}

// In the everyday run every bit of the smallest files, one of each byte of the others.
TEST(Damage, EveryFlippedBitIsFoundByVerifyAndGivesNoWrongVoxel) {
  for (Damaged& file : small_files()) {
    std::vector<std::uint8_t> bytes = sample_file_bytes(file.volume);
    ASSERT_FALSE(is_noticed_by_verify(bytes)) << file.name;
    // A step of 9 takes a bit of every byte but few, each time another one.
    const std::size_t step = is_full_form() || bytes.size() < 1000 ? 1 : 9;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); bit += step) {
      const auto mask = static_cast<std::uint8_t>(1 << bit % 8);
      bytes[bit / 8] ^= mask;
      ASSERT_TRUE(is_noticed_by_verify(bytes)) << file.name << " bit " << bit;
      ASSERT_EQ(wrong_levels(bytes, file.volume), 0) << file.name << " bit " << bit;
      bytes[bit / 8] ^= mask;
    }
  }
}

TEST(Damage, APartialReadThatTouchesTheBitThrows) {
  SampleVolume volume = make_sample({66, 20, 3}, VoxelType::uint8, Pattern::gradient);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto sound = open_bytes(bytes);
  for (std::int64_t x = 0; x < 2; ++x) {
    const BrickEntry entry = sound->brick(0, {x, 0, 0});
    for (int level = 0; level < kTierLevels; ++level) {
      const BrickEntry::StoredPiece& piece =
          entry.pieces[static_cast<std::size_t>(piece_of_level(level))];
      for (std::uint64_t at = piece.offset; at < piece.offset + piece.length; ++at) {
        bytes[at] ^= 0x40;
        const auto reader = open_bytes(bytes);
        const Size3 side = brick_side_at(volume.levels, level);
        const Box voxel{{x * side.x, 0, 0}, {x * side.x + 1, 1, 1}};
        ASSERT_THROW(read_samples(*reader, voxel, level), Error) << "byte " << at;
        bytes[at] ^= 0x40;
      }
    }
  }
}

TEST(Damage, EveryTruncationIsRejected) {
  for (Damaged& file : small_files()) {
    const std::vector<std::uint8_t> bytes = sample_file_bytes(file.volume);
    for (std::size_t length = 0; length < bytes.size(); ++length) {
      try {
        open_bytes({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
        FAIL() << file.name << " opened at length " << length;
      } catch (const Error& error) {
        const ErrorKind expected = length == 0 ? ErrorKind::not_octavo : ErrorKind::truncated;
        ASSERT_EQ(error.kind(), expected) << file.name << " length " << length;
      }
    }
  }
}

TEST(Damage, AppendedBytesAreRejected) {
  for (Damaged& file : small_files()) {
    std::vector<std::uint8_t> bytes = sample_file_bytes(file.volume);
    for (int count = 0; count < 600; ++count) {
      bytes.push_back(static_cast<std::uint8_t>(count));
      EXPECT_THROW(open_bytes(bytes), Error);
    }
  }
}

TEST(Damage, SwappedBricksAreFound) {
  SampleVolume volume = make_sample({128, 20, 3}, VoxelType::uint8, Pattern::noisy_half);
  std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  const auto reader = open_bytes(bytes);
  const BrickEntry::StoredPiece a = reader->brick(0, {0, 0, 0}).pieces[0];
  const BrickEntry::StoredPiece b = reader->brick(0, {1, 0, 0}).pieces[0];
  const std::uint64_t length = std::min(a.length, b.length);
  ASSERT_GT(length, 0u);
  const auto at = [&](std::uint64_t offset) {
    return bytes.begin() + static_cast<std::ptrdiff_t>(offset);
  };
  std::swap_ranges(at(a.offset), at(a.offset + length), at(b.offset));
  EXPECT_TRUE(is_noticed_by_verify(bytes));
  EXPECT_EQ(wrong_levels(bytes, volume), 0);
}

TEST(Damage, ABrickOfAnotherFileIsFoundThoughItsIndexCameAlong) {
  // Two files alike in everything but one voxel of the first brick; from the second brick on their
  // segments have the same bytes, but not the same checksums.
  SampleVolume one = make_sample({128, 20, 3}, VoxelType::uint8, Pattern::gradient);
  SampleVolume two = make_sample({128, 20, 3}, VoxelType::uint8, Pattern::gradient);
  two.samples[0][0] = 99;
  const auto a = open_bytes(sample_file_bytes(one));
  const auto b = open_bytes(sample_file_bytes(two));
  ASSERT_NE(a->build_id(), b->build_id());
  const BrickEntry foreign = b->brick(0, {1, 0, 0});
  EXPECT_THROW(a->read_piece(foreign, 0), Error);
  EXPECT_NO_THROW(b->read_piece(foreign, 0));
}

TEST(Damage, CoarseDamageIsFound) {
  SampleVolume volume = make_sample({40, 40, 40}, VoxelType::int16, Pattern::noisy_half);
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  std::mt19937 random(11);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bad = good;
    const std::size_t at = random() % bad.size();
    const std::size_t length = std::min<std::size_t>(random() % 700 + 1, bad.size() - at);
    const std::uint8_t value = random() % 2 == 0 ? 0 : 0xff;
    std::fill_n(bad.begin() + static_cast<std::ptrdiff_t>(at), length, value);
    if (bad == good) continue;
    ASSERT_TRUE(is_noticed_by_verify(bad)) << length << " bytes at " << at;
    ASSERT_EQ(wrong_levels(bad, volume), 0);
  }
}

}  // namespace
}  // namespace octavo
