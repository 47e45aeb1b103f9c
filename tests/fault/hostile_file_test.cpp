// Files whose checksums fit and whose contents lie. Memory is counted.
#include <gtest/gtest.h>

#include <set>

#include "fault/reseal.h"
#include "octavo/file/index.h"
#include "octavo/file/verify.h"
#include "octavo/file/write/index_builder.h"
#include "support/counted_memory.h"
#include "support/goal_cases.h"
#include "support/sample_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

// Opens, verifies and reads `bytes`, none of which may crash, hang or need much memory. Bytes that
// the reader may hold beyond those of the file itself are bounded.
void exercise(const std::vector<std::uint8_t>& bytes) {
  const auto source = byte_source_of(bytes, "hostile.8vo");
  const std::size_t before = live_bytes();
  reset_peak();
  try {
    const auto reader = FileReader::open(source);
    const Index3 corner{0, 0, 0};
    for (int level = 0; level < reader->levels().count(); ++level) {
      try {
        read_samples(*reader, {corner, {1, 1, 1}}, level);
      } catch (const Error&) {
        continue;
      }
    }
    NoProgress progress;
    verify_file(source, {}, progress);
  } catch (const Error&) {
    // Rejected.
  }
  ASSERT_LE(peak_bytes() - before, (std::size_t{64} << 20) + 2 * bytes.size());
}

const std::uint64_t kValues[] = {0,
                                 1,
                                 std::uint64_t{1} << 21,
                                 (std::uint64_t{1} << 31) - 1,
                                 std::uint64_t{1} << 31,
                                 std::uint64_t{1} << 32,
                                 std::uint64_t{1} << 63,
                                 (std::uint64_t{1} << 63) - 1,
                                 ~std::uint64_t{0} - 1,
                                 ~std::uint64_t{0}};

SampleVolume sample() { return make_sample({66, 20, 70}, VoxelType::uint8, Pattern::noisy_half); }

TEST(HostileFile, AnyHeaderFieldMayHoldAnything) {
  SampleVolume volume = sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  for (std::size_t at = 8; at + 8 <= 508; ++at) {
    for (const std::uint64_t value : kValues) {
      std::vector<std::uint8_t> bad = good;
      store_little_endian(value, bad.data() + at);
      reseal(bad, layout);
      exercise(bad);
    }
  }
}

TEST(HostileFile, SectionsOffByOneAreRejected) {
  SampleVolume volume = sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  for (const std::size_t field : {224u, 232u, 240u, 256u, 264u, 280u, 288u, 304u, 312u}) {
    const auto value = load_little_endian<std::uint64_t>(good.data() + field);
    for (const std::uint64_t step : {std::uint64_t{1}, ~std::uint64_t{0}}) {
      std::vector<std::uint8_t> bad = good;
      store_little_endian(value + step, bad.data() + field);
      reseal(bad, layout);
      EXPECT_THROW(open_bytes(bad), Error) << "field at " << field;
    }
  }
}

TEST(HostileFile, HugeSizesAreRejectedBeforeMemoryIsAsked) {
  SampleVolume volume = sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  FileHeader huge = layout;
  huge.description.size = {kMaxAxis, kMaxAxis, kMaxAxis};
  huge.halvings = choose_halvings(huge.description.size, {1, 1, 1});
  const HeaderBlock block = encode_header(huge);
  std::vector<std::uint8_t> bad = good;
  std::copy(block.begin(), block.end(), bad.begin());
  reseal(bad, layout);
  EXPECT_THROW(open_bytes(bad), Error);
  exercise(bad);
}

TEST(HostileFile, TheCodingOfFloatsAndTheMaxErrorMayHoldAnything) {
  SampleVolume volume = make_lossy_float_sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  for (const std::size_t first : {208u, 328u}) {
    for (std::size_t at = first; at < first + 32; ++at) {
      for (const std::uint64_t value : kValues) {
        std::vector<std::uint8_t> bad = good;
        store_little_endian(value, bad.data() + at);
        reseal(bad, layout);
        exercise(bad);
      }
    }
  }
}

TEST(HostileFile, PagesWithoutBytesAreRejected) {
  SampleVolume volume = sample();
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  FileHeader header = header_of(good);
  const ByteSpan bytes(good);
  const auto root = bytes.subspan(header.root.offset, header.root.length);
  const IndexRoot index = parse_root(root, volume.levels, header);
  const auto with_page_lengths = [&](bool are_zero) {
    IndexRoot lie = index;
    for (int tier = 0; tier < volume.levels.tier_count(); ++tier) {
      auto& pages = lie.tiers[static_cast<std::size_t>(tier)].pages;
      for (std::size_t i = 0; i < pages.size(); ++i) {
        if (are_zero) pages[i].length = 0;
        // A root that is written holds totals.
        for (int piece = 0; piece < piece_count(volume.levels.tier_level_count(tier)); ++piece) {
          auto& start = pages[i].piece_start[static_cast<std::size_t>(piece)];
          start = index.piece_end(tier, i, piece) - start;
        }
      }
    }
    return encode_root(lie, volume.levels, header);
  };
  // The root differs in nothing but the lengths of the pages, which fill their section.
  EXPECT_NO_THROW(parse_root(with_page_lengths(false), volume.levels, header));
  header.pages.length = 0;
  try {
    parse_root(with_page_lengths(true), volume.levels, header);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::corrupt);
    EXPECT_NE(error.detail().find("a page too short"), std::string::npos) << error.detail();
  }
}

/// What a byte is set to: ends of the ranges that bytes of a varint have, every flipped bit, and
/// every sixteenth value, others at each place; all 256 in the full form.
std::set<std::uint8_t> values_at(std::uint64_t place, std::uint8_t good) {
  std::set<std::uint8_t> values = {0, 1, 2, 0x7f, 0x80, 0x81, 0xfe, 0xff};
  for (int bit = 0; bit < 8; ++bit) values.insert(static_cast<std::uint8_t>(good ^ 1 << bit));
  const int step = testing::is_full_form() ? 1 : 16;
  for (int value = static_cast<int>(place) % step; value < 256; value += step) {
    values.insert(static_cast<std::uint8_t>(value));
  }
  return values;
}

void exercise_root(SampleVolume volume) {
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  for (std::uint64_t at = layout.root.offset; at < layout.root.end(); ++at) {
    for (const std::uint8_t value : values_at(at, good[at])) {
      std::vector<std::uint8_t> bad = good;
      bad[at] = value;
      reseal(bad, layout);
      exercise(bad);
    }
  }
}

TEST(HostileFile, AnyByteOfTheRootMayHoldAnything) {
  exercise_root(sample());
  exercise_root(make_lossy_float_sample());
}

void exercise_page(SampleVolume volume) {
  const std::vector<std::uint8_t> good = sample_file_bytes(volume);
  const FileHeader layout = header_of(good);
  const auto parsed = parse_root(ByteSpan(good).subspan(layout.root.offset, layout.root.length),
                                 volume.levels, layout);
  const PageRef page = parsed.tiers[0].pages[1];
  std::uint8_t old_crc[4];
  store_little_endian(page.crc, old_crc);
  const auto crc_at = std::search(good.begin() + static_cast<std::ptrdiff_t>(layout.root.offset),
                                  good.end(), old_crc, old_crc + 4) -
                      good.begin();
  for (std::uint64_t at = page.offset; at < page.offset + page.length; ++at) {
    for (const int value : {0, 1, 2, 0x7f, 0x80, 0x81, 0xfe, 0xff}) {
      std::vector<std::uint8_t> bad = good;
      bad[at] = static_cast<std::uint8_t>(value);
      const std::uint32_t crc = crc32c(ByteSpan(bad).subspan(page.offset, page.length));
      store_little_endian(crc, bad.data() + crc_at);
      reseal(bad, layout);
      exercise(bad);
    }
  }
}

TEST(HostileFile, AnyByteOfAPageMayHoldAnything) {
  exercise_page(sample());
  exercise_page(make_lossy_float_sample());
}

}  // namespace
}  // namespace octavo
