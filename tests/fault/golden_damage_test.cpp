// Damage of every sort to the kept files of tests/golden: all of it is found, none of it gives a
// wrong voxel, and verify tells where it is.
// The smallest files are always tried exhaustively, all others under tools/nightly.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "fault/reseal.h"
#include "octavo/file/index.h"
#include "octavo/file/open_file.h"
#include "octavo/file/pieces.h"
#include "octavo/file/repair/repair_bits.h"
#include "octavo/file/repair/salvage.h"
#include "octavo/file/verify.h"
#include "support/brick_pieces.h"
#include "support/goal_cases.h"
#include "support/sample_file.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

namespace fs = std::filesystem;
using namespace octavo::testing;
using FileContent = std::vector<std::uint8_t>;

constexpr std::size_t kExhaustiveBytes = 2000;

struct Golden {
  std::string name;
  FileContent bytes;
  std::shared_ptr<FileReader> reader;
  std::vector<Bytes> levels;  ///< the voxels of each
};

const std::vector<Golden>& goldens() {
  static const std::vector<Golden> all = [] {
    std::vector<Golden> files;
    for (const auto& entry : fs::directory_iterator(source_folder() + "/tests/golden/v1")) {
      if (entry.path().extension() != ".8vo") continue;
      std::ifstream in(entry.path(), std::ios::binary);
      Golden& file = files.emplace_back();
      file.name = entry.path().filename().string();
      file.bytes.assign(std::istreambuf_iterator<char>(in), {});
      file.reader = open_bytes(file.bytes);
      for (int level = 0; level < file.reader->levels().count(); ++level) {
        file.levels.push_back(
            read_samples(*file.reader, box_of(file.reader->levels().size(level)), level));
      }
    }
    std::sort(files.begin(), files.end(),
              [](const Golden& a, const Golden& b) { return a.name < b.name; });
    return files;
  }();
  return all;
}

// The report of a file that opens, or nothing where it is rejected.
std::optional<VerifyReport> verify_bytes(const FileContent& bytes, bool decode) {
  NoProgress progress;
  try {
    return verify_file(byte_source_of(bytes, "damaged.8vo"), {decode, {}}, progress);
  } catch (const Error& error) {
    EXPECT_TRUE(error.kind() == ErrorKind::corrupt || error.kind() == ErrorKind::truncated ||
                error.kind() == ErrorKind::not_octavo ||
                error.kind() == ErrorKind::unsupported_version ||
                error.kind() == ErrorKind::limit_exceeded)
        << error.what();
    return std::nullopt;
  }
}

bool is_noticed(const FileContent& bytes, bool decode) {
  const auto report = verify_bytes(bytes, decode);
  return !report || !report->is_sound();
}

bool gives_wrong_voxels(const FileContent& bytes, const Golden& golden) {
  try {
    const auto reader = open_bytes(bytes);
    for (int level = 0; level < reader->levels().count(); ++level) {
      try {
        const Bytes voxels = read_samples(*reader, box_of(reader->levels().size(level)), level);
        if (voxels != golden.levels.at(static_cast<std::size_t>(level))) return true;
      } catch (const Error&) {
        continue;
      }
    }
  } catch (const Error&) {
    return false;
  }
  return false;
}

IndexRoot root_of(const Golden& golden) {
  const FileHeader header = header_of(golden.bytes);
  return parse_root(ByteSpan(golden.bytes).subspan(header.root.offset, header.root.length),
                    golden.reader->levels(), header);
}

TEST(GoldenDamage, EveryFlippedBitOfTheSmallFilesIsFound) {
  int tried = 0;
  for (const Golden& golden : goldens()) {
    if (golden.bytes.size() > kExhaustiveBytes) continue;
    ++tried;
    FileContent bytes = golden.bytes;
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      ASSERT_TRUE(is_noticed(bytes, false)) << golden.name << " bit " << bit;
      ASSERT_FALSE(gives_wrong_voxels(bytes, golden)) << golden.name << " bit " << bit;
      bytes[bit / 8] = golden.bytes[bit / 8];
    }
  }
  EXPECT_GE(tried, 2);
}

TEST(GoldenDamage, FlippedBitsOfTheOtherFilesAreFound) {
  const std::uint64_t most = case_count(30, 300'000);
  std::uint64_t all = 0;
  for (const Golden& golden : goldens()) all += std::min(most, 8 * golden.bytes.size());
  GoalCases goal("B1", "flipped bits found", all);
  std::mt19937_64 random(21);
  for (const Golden& golden : goldens()) {
    FileContent bytes = golden.bytes;
    const std::size_t bits = 8 * bytes.size();
    for (std::size_t i = 0; i < std::min(most, bits) && goal.next(); ++i) {
      const std::size_t bit = most >= bits ? i : random() % bits;
      bytes[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
      ASSERT_TRUE(is_noticed(bytes, false)) << golden.name << " bit " << bit;
      if (i % 16 == 0) {
        ASSERT_FALSE(gives_wrong_voxels(bytes, golden)) << golden.name << " bit " << bit;
      }
      bytes[bit / 8] = golden.bytes[bit / 8];
    }
  }
}

TEST(GoldenDamage, EveryLengthButTheWholeIsRejected) {
  const std::uint64_t cases = case_count(400, 30'000);
  const auto step_of = [&](const Golden& golden) {
    return std::max<std::size_t>(1, golden.bytes.size() / cases);
  };
  std::uint64_t all = 0;
  for (const Golden& golden : goldens()) {
    all += (golden.bytes.size() + step_of(golden) - 1) / step_of(golden);
  }
  GoalCases goal("B2", "lengths rejected", all);
  for (const Golden& golden : goldens()) {
    for (std::size_t length = 0; length < golden.bytes.size() && goal.next();
         length += step_of(golden)) {
      const auto end = golden.bytes.begin() + static_cast<std::ptrdiff_t>(length);
      try {
        open_bytes({golden.bytes.begin(), end});
        FAIL() << golden.name << " opened at length " << length;
      } catch (const Error& error) {
        const ErrorKind expected = length == 0 ? ErrorKind::not_octavo : ErrorKind::truncated;
        ASSERT_EQ(error.kind(), expected) << golden.name << " length " << length;
      }
    }
  }
}

// The sorts of damage. Each changes `bytes`, a copy of the golden file, or leaves them as they are
// where the file has nothing of that sort.
using Random = std::mt19937_64;
using Damager = void (*)(const Golden&, FileContent&, Random&);

std::ptrdiff_t place_in(const FileContent& bytes, Random& random) {
  return static_cast<std::ptrdiff_t>(random() % bytes.size());
}

void set_run(const Golden&, FileContent& bytes, Random& random) {
  const auto at = static_cast<std::size_t>(place_in(bytes, random));
  const std::size_t length = std::min<std::size_t>(random() % 64 + 1, bytes.size() - at);
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), length,
              static_cast<std::uint8_t>(random() % 2 == 0 ? 0 : 0xff));
}

void zero_sector(const Golden&, FileContent& bytes, Random& random) {
  const std::size_t at = static_cast<std::size_t>(place_in(bytes, random)) / 512 * 512;
  std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at),
              std::min<std::size_t>(512, bytes.size() - at), std::uint8_t{0});
}

void swap_bricks(const Golden& golden, FileContent& bytes, Random& random) {
  const std::vector<BrickPiece> places = pieces_of(*golden.reader);
  if (places.empty()) return;
  const BrickEntry::StoredPiece a = places[random() % places.size()].piece;
  const BrickEntry::StoredPiece b = places[random() % places.size()].piece;
  const auto at = [&](std::uint64_t offset) {
    return bytes.begin() + static_cast<std::ptrdiff_t>(offset);
  };
  const std::uint64_t length = std::min(a.length, b.length);
  const std::uint64_t distance = a.offset < b.offset ? b.offset - a.offset : a.offset - b.offset;
  if (distance < length) return;
  std::swap_ranges(at(a.offset), at(a.offset + length), at(b.offset));
}

void take_foreign_brick(const Golden& golden, FileContent& bytes, Random& random) {
  const Golden& other = goldens()[random() % goldens().size()];
  const std::vector<BrickPiece> here = pieces_of(*golden.reader);
  const std::vector<BrickPiece> there = pieces_of(*other.reader);
  if (here.empty() || there.empty()) return;
  const std::size_t i = random() % here.size();
  const BrickEntry::StoredPiece to = here[i].piece;
  const BrickEntry::StoredPiece from = there[i % there.size()].piece;
  std::copy_n(other.bytes.begin() + static_cast<std::ptrdiff_t>(from.offset),
              std::min(from.length, to.length),
              bytes.begin() + static_cast<std::ptrdiff_t>(to.offset));
}

// One page of the index, by place and length.
ByteSpan random_page(const Golden& golden, Random& random, std::ptrdiff_t& at) {
  const IndexRoot root = root_of(golden);
  const TierIndex& tier = root.tiers[random() % root.tiers.size()];
  const PageRef& page = tier.pages[random() % tier.pages.size()];
  at = static_cast<std::ptrdiff_t>(page.offset);
  return ByteSpan(golden.bytes).subspan(page.offset, page.length);
}

void drop_page(const Golden& golden, FileContent& bytes, Random& random) {
  std::ptrdiff_t at = 0;
  const ByteSpan page = random_page(golden, random, at);
  bytes.erase(bytes.begin() + at, bytes.begin() + at + static_cast<std::ptrdiff_t>(page.size()));
}

void double_page(const Golden& golden, FileContent& bytes, Random& random) {
  std::ptrdiff_t at = 0;
  const ByteSpan page = random_page(golden, random, at);
  bytes.insert(bytes.begin() + at, page.begin(), page.end());
}

// The file keeps its length: what follows the page moves up, and the end is filled.
void drop_page_keep_length(const Golden& golden, FileContent& bytes, Random& random) {
  drop_page(golden, bytes, random);
  bytes.resize(golden.bytes.size());
}

void append_junk(const Golden&, FileContent& bytes, Random& random) {
  const std::size_t count = random() % 600 + 1;
  for (std::size_t i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(random()));
}

void double_stretch(const Golden&, FileContent& bytes, Random& random) {
  const auto from = static_cast<std::size_t>(place_in(bytes, random));
  const auto to = static_cast<std::size_t>(place_in(bytes, random));
  const std::size_t length = std::min<std::size_t>(
      random() % 512 + 1, bytes.size() - std::max(from, to));
  const FileContent stretch(bytes.begin() + static_cast<std::ptrdiff_t>(from),
                            bytes.begin() + static_cast<std::ptrdiff_t>(from + length));
  std::copy(stretch.begin(), stretch.end(), bytes.begin() + static_cast<std::ptrdiff_t>(to));
}

struct Sort {
  const char* name;
  Damager damage;
};

constexpr Sort kSorts[] = {{"bytes set", set_run},
                           {"sector zeroed", zero_sector},
                           {"bricks swapped", swap_bricks},
                           {"foreign brick", take_foreign_brick},
                           {"page dropped", drop_page},
                           {"page doubled", double_page},
                           {"page dropped, length kept", drop_page_keep_length},
                           {"junk appended", append_junk},
                           {"stretch copied", double_stretch}};

TEST(GoldenDamage, DamageOfEverySortIsFound) {
  const std::uint64_t cases = case_count(4, 600);
  GoalCases goal("B3", "damages of nine sorts found",
                 std::size(kSorts) * goldens().size() * cases);
  std::uint64_t changed_nothing = 0;
  Random random(22);
  for (const Sort& sort : kSorts) {
    std::size_t damaged = 0;
    for (const Golden& golden : goldens()) {
      for (std::size_t i = 0; i < cases && goal.next(); ++i) {
        FileContent bytes = golden.bytes;
        sort.damage(golden, bytes, random);
        if (bytes == golden.bytes) {
          ++changed_nothing;
          continue;
        }
        ++damaged;
        ASSERT_TRUE(is_noticed(bytes, true)) << golden.name << ": " << sort.name << " case " << i;
        ASSERT_FALSE(gives_wrong_voxels(bytes, golden))
            << golden.name << ": " << sort.name << " case " << i;
      }
    }
    EXPECT_TRUE(damaged > cases || !goal.is_in_time()) << sort.name;
  }
  goal.tell("of which " + std::to_string(changed_nothing) + " changed no byte");
}

// The golden's voxels and `salvaged` agree outside the damaged brick, at every level; a brick
// without coarsest samples holds all its levels in the finest piece.
void expect_equal_outside(const Golden& golden, const BrickPiece& place, int level,
                          const Bytes& salvaged) {
  const Levels& levels = golden.reader->levels();
  const Size3& size = levels.size(level);
  const Size3 side = brick_side_at(levels, level);
  const bool is_stored = place.entry.pieces.back().length == 0;
  const int first = Levels::first_level(place.entry.tier);
  const bool may_differ = Levels::tier_of(level) == place.entry.tier &&
                          (piece_of_level(level - first) <= place.level - first || is_stored);
  const auto width =
      static_cast<std::size_t>(bytes_per_voxel(golden.reader->description().type));
  const Bytes& original = golden.levels[static_cast<std::size_t>(level)];
  ASSERT_EQ(salvaged.size(), original.size());
  std::size_t i = 0;
  for (Index3 p; p.z < size.z; ++p.z) {
    for (p.y = 0; p.y < size.y; ++p.y) {
      for (p.x = 0; p.x < size.x; ++p.x, i += width) {
        const Index3 brick{p.x / side.x, p.y / side.y, p.z / side.z};
        if (may_differ && brick == place.entry.brick) continue;
        ASSERT_TRUE(std::equal(original.begin() + static_cast<std::ptrdiff_t>(i),
                               original.begin() + static_cast<std::ptrdiff_t>(i + width),
                               salvaged.begin() + static_cast<std::ptrdiff_t>(i)))
            << golden.name << " level " << level;
      }
    }
  }
}

TEST(GoldenDamage, VerifyNamesTheBrickAndTheOthersAreSalvaged) {
  const std::uint64_t cases = case_count(4, 600);
  std::uint64_t count = 0;
  for (const Golden& golden : goldens()) {
    count += std::min(cases, pieces_of(*golden.reader).size());
  }
  GoalCases goal("B4", "damaged bricks named and all others salvaged", count);
  Random random(23);
  for (const Golden& golden : goldens()) {
    const std::vector<BrickPiece> places = pieces_of(*golden.reader);
    for (std::size_t i = 0; i < std::min(cases, places.size()) && goal.next(); ++i) {
      const BrickPiece& place =
          places[cases >= places.size() ? i : random() % places.size()];
      FileContent bytes = golden.bytes;
      const std::uint64_t at = place.piece.offset + random() % place.piece.length;
      const int bit = static_cast<int>(random() % 8);
      bytes[at] ^= static_cast<std::uint8_t>(1 << bit);
      const auto report = verify_bytes(bytes, true);
      ASSERT_TRUE(report.has_value());
      ASSERT_EQ(report->damage_count, 1) << golden.name;
      EXPECT_EQ(report->damaged_brick_count, 1);
      const Damage& damage = report->damages.front();
      EXPECT_EQ(damage.what, "brick");
      EXPECT_EQ(damage.code, place.entry.code);
      EXPECT_EQ(damage.tier, place.entry.tier);
      EXPECT_EQ(damage.level, place.level);
      EXPECT_EQ(damage.offset, place.piece.offset);
      EXPECT_EQ(damage.flipped_byte, at);
      EXPECT_EQ(damage.flipped_bit, bit);
      char name[96];
      std::snprintf(name, sizeof name, "brick o-code 0x%llx level %d at byte %llu: checksum ",
                    static_cast<unsigned long long>(place.entry.code), place.level,
                    static_cast<unsigned long long>(place.piece.offset));
      EXPECT_EQ(damage.detail.rfind(name, 0), 0u) << damage.detail;

      const SalvageReader salvage(open_bytes(bytes), {i % 2 == 0, {}});
      for (int level = 0; level < golden.reader->levels().count(); ++level) {
        const Box all = box_of(golden.reader->levels().size(level));
        expect_equal_outside(golden, place, level, read_samples(salvage, all, level));
      }
    }
  }
}

// Parts other than thumbnails, and the long pieces of stored voxels and of exact floats: nothing
// else tells their damage from a flipped bit.
bool is_guesswork(const Golden& golden, std::uint64_t at) {
  constexpr std::uint64_t kLong = 512;
  const OpenFile file(byte_source_of(golden.bytes, golden.name), {});
  for (const PartEntry& part : file.parts()) {
    const bool is_inside = at >= part.bytes.offset && at < part.bytes.end();
    if (is_inside && part.tag != kThumbnailTag) return true;
  }
  for (const BrickPiece& place : pieces_of(*golden.reader)) {
    const BrickEntry& entry = place.entry;
    const bool is_here =
        at >= place.piece.offset && at - place.piece.offset < place.piece.length;
    if (!is_here) continue;
    const bool is_stored = entry.pieces.size() > 1 && entry.pieces.back().length == 0;
    const bool has_places = place.level == 0 &&
                            golden.reader->description().codec_type() == VoxelType::float32;
    return (is_stored || has_places) && place.piece.length > kLong;
  }
  return false;
}

TEST(GoldenDamage, ANamedFlippedBitIsTurnedBackOrRejected) {
  const std::uint64_t cases = case_count(8, 30);
  Random random(29);
  NoProgress progress;
  std::uint64_t rejected = 0;
  for (const Golden& golden : goldens()) {
    for (std::uint64_t i = 0; i < cases; ++i) {
      const std::size_t at = random() % golden.bytes.size();
      MemoryStorage storage;
      storage.files["bad.8vo"] = std::make_shared<FileContent>(golden.bytes);
      storage.files["bad.8vo"]->at(at) ^= static_cast<std::uint8_t>(1 << random() % 8);
      const bool is_rejected = is_guesswork(golden, at);
      try {
        repair_bits(storage, "bad.8vo", "out.8vo", {}, progress);
        EXPECT_FALSE(is_rejected) << golden.name << " byte " << at;
        EXPECT_EQ(*storage.files.at("out.8vo"), golden.bytes) << golden.name << " byte " << at;
      } catch (const Error& error) {
        EXPECT_TRUE(is_rejected) << golden.name << ": " << error.what();
        EXPECT_EQ(storage.files.size(), 1u);
        ++rejected;
      }
    }
  }
  EXPECT_GT(rejected, cases);
}

TEST(GoldenDamage, WhatIsNoBrickIsNamedAsWell) {
  for (const Golden& golden : goldens()) {
    const FileHeader header = header_of(golden.bytes);
    const IndexRoot root = root_of(golden);
    const auto damage_at = [&](std::uint64_t at) {
      FileContent bytes = golden.bytes;
      bytes[at] ^= 0x20;
      const auto report = verify_bytes(bytes, true);
      EXPECT_TRUE(report && report->damage_count == 1) << golden.name << " byte " << at;
      if (!report || report->damages.empty()) return Damage{};
      EXPECT_EQ(report->damages.front().flipped_byte, at) << report->damages.front().detail;
      return report->damages.front();
    };
    for (std::int64_t slab = 0; slab < root.tiers[0].grid.z; ++slab) {
      const std::uint64_t offset = root.slab_trailer_offset(slab);
      const std::uint32_t length = root.slab_trailer_bytes[static_cast<std::size_t>(slab)];
      for (const std::uint64_t at : {offset, offset + length / 2, offset + length - 1}) {
        const Damage damage = damage_at(at);
        EXPECT_EQ(damage.what, "slab trailer");
        EXPECT_EQ(damage.code, static_cast<std::uint64_t>(slab));
      }
    }
    for (std::size_t model = 0; model < root.models.size(); ++model) {
      if (root.models[model].length == 0) continue;
      const Damage damage = damage_at(root.models[model].offset);
      EXPECT_EQ(damage.what, "model");
      EXPECT_NE(damage.detail.find("cannot be read"), std::string::npos) << damage.detail;
      EXPECT_EQ(damage.code, model);
    }
    for (const TierIndex& tier : root.tiers) {
      for (const PageRef& page : tier.pages) {
        const Damage damage = damage_at(page.offset + page.length - 1);
        EXPECT_EQ(damage.what, "index page");
        EXPECT_EQ(damage.offset, page.offset);
      }
    }
    // Without these nothing can be looked into: opening says which, and which bit.
    struct Part {
      std::uint64_t at;
      const char* name;
    };
    for (const Part& part : {Part{100, "header"}, Part{509, "header"},
                             Part{header.metadata.offset, "metadata at byte "},
                             Part{header.root.offset, "index root at byte "},
                             Part{golden.bytes.size() - 60, "trailer at byte "},
                             Part{golden.bytes.size() - 2, "trailer at byte "}}) {
      FileContent bytes = golden.bytes;
      bytes[part.at] ^= 1;
      try {
        open_bytes(bytes);
        FAIL() << golden.name << " opened with a damaged " << part.name;
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::corrupt);
        EXPECT_EQ(error.detail().rfind(part.name, 0), 0u) << error.detail();
        const std::string flip = "(one flipped bit, byte " + std::to_string(part.at) + ")";
        EXPECT_NE(error.detail().find(flip), std::string::npos) << error.detail();
      }
    }
  }
}

}  // namespace
}  // namespace octavo
