#include "octavo/io/images/tiff_layout.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include <array>
#include <cstring>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// A page of 40 x 32 values of 16 bits: 4 strips of 8 rows, or 6 tiles.
TiffSample blocks_sample(bool has_tiles, std::uint16_t compression) {
  TiffSample sample;
  sample.width = 40;
  sample.height = 32;
  sample.bits = 16;
  sample.compression = compression;
  sample.rows_per_strip = 8;
  sample.tile = has_tiles ? 16 : 0;
  sample.pages = {counted(40 * 32 * 2, 1)};
  return sample;
}

/// The list of offsets or byte counts, which stands behind the directory.
std::vector<std::uint32_t> list_in(const std::string& bytes, std::uint16_t tag) {
  const std::size_t entry = entry_of(bytes, tag);
  std::array<std::uint32_t, 2> place{};
  std::memcpy(place.data(), bytes.data() + entry + 4, sizeof place);
  const bool is_short = bytes[entry + 2] == TIFF_SHORT;
  std::vector<std::uint32_t> values(place[0]);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t width = is_short ? 2 : 4;
    std::memcpy(&values[i], bytes.data() + place[1] + i * width, width);
  }
  return values;
}

struct BlockTags {
  std::uint16_t offsets = 0;
  std::uint16_t byte_counts = 0;
};

BlockTags tags_of(bool has_tiles) {
  return has_tiles ? BlockTags{TIFFTAG_TILEOFFSETS, TIFFTAG_TILEBYTECOUNTS}
                   : BlockTags{TIFFTAG_STRIPOFFSETS, TIFFTAG_STRIPBYTECOUNTS};
}

TEST(TiffLayout, WithAnotherNumberOfBlocksThanThePageHasIsRejected) {
  const TempFolder folder;
  for (const bool has_tiles : {false, true}) {
    for (const std::uint16_t compression : std::array<std::uint16_t, 2>{1, 8}) {
      write_tiff(folder.file("a.tif"), blocks_sample(has_tiles, compression));
      const std::string whole = read_file(folder.file("a.tif"));
      const BlockTags tags = tags_of(has_tiles);
      for (const std::uint16_t tag : {tags.offsets, tags.byte_counts}) {
        const std::vector<std::uint32_t> list = list_in(whole, tag);
        ASSERT_EQ(list.size(), has_tiles ? 6U : 4U);
        for (std::size_t count = 0; count <= list.size() + 2; ++count) {
          std::string bytes = whole;
          std::vector<std::uint32_t> other = list;
          other.resize(count, list.back());
          set_numbers(bytes, tag, other);
          write_file(folder.file("a.tif"), bytes);
          if (count == list.size()) {
            EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})),
                      blocks_sample(has_tiles, 1).pages[0]);
            continue;
          }
          expect_rejected(folder.file("a.tif"),
                          {"page 0 has " + std::to_string(list.size()) +
                           (has_tiles ? " tiles" : " strips") + " by its size, and tag " +
                           std::to_string(tag) + " lists " + std::to_string(count)});
        }
      }
    }
  }
}

TEST(TiffLayout, OfSamplesApartHasTheBlocksOfEachOfThem) {
  const TempFolder folder;
  TiffSample sample = blocks_sample(false, 1);
  sample.samples = 3;
  sample.separate = true;
  sample.pages = {counted(40 * 32 * 2 * 3, 1)};
  write_tiff(folder.file("a.tif"), sample);
  SourceOptions options;
  options.channel = "blue";
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)),
            sample.pages[0].substr(40 * 32 * 2 * 2));
  std::string bytes = read_file(folder.file("a.tif"));
  std::vector<std::uint32_t> list = list_in(bytes, TIFFTAG_STRIPOFFSETS);
  ASSERT_EQ(list.size(), 12U);
  list.resize(4);
  set_numbers(bytes, TIFFTAG_STRIPOFFSETS, list);
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"12 strips by its size", "lists 4"}, options);
}

TEST(TiffLayout, WithABlockInTheHeadOrInADirectoryIsRejected) {
  const TempFolder folder;
  for (const bool has_tiles : {false, true}) {
    for (const std::uint16_t compression : std::array<std::uint16_t, 2>{1, 8}) {
      TiffSample sample = blocks_sample(has_tiles, compression);
      sample.pages.push_back(sample.pages[0]);
      write_tiff(folder.file("a.tif"), sample);
      const std::string whole = read_file(folder.file("a.tif"));
      const BlockTags tags = tags_of(has_tiles);
      std::array<std::uint32_t, 1> first_directory{};
      std::memcpy(first_directory.data(), whole.data() + 4, 4);
      const auto last_entry = static_cast<std::uint32_t>(entry_of(whole, tags.offsets));
      // entry_of finds that of the second page.
      const auto error_at = [&](std::uint32_t offset) {
        std::string bytes = whole;
        std::vector<std::uint32_t> list = list_in(whole, tags.offsets);
        list[1] = offset;
        set_numbers(bytes, tags.offsets, list);
        write_file(folder.file("a.tif"), bytes);
        try {
          open_source({folder.file("a.tif")}, {});
        } catch (const Error& error) {
          return with_hints(error);
        }
        return std::string();
      };
      const std::string block = has_tiles ? "tile 1 of page 1 " : "strip 1 of page 1 ";
      for (const std::uint32_t offset : {0U, 1U, 7U}) {
        const std::string error = error_at(offset);
        EXPECT_TRUE(contains(error, block + "begins at byte " + std::to_string(offset) +
                                        ", in the head of the file"))
            << error;
      }
      for (const std::uint32_t offset : {last_entry, first_directory[0], first_directory[0] + 9}) {
        const std::string error = error_at(offset);
        EXPECT_TRUE(contains(error, block + "begins at byte " + std::to_string(offset)) &&
                    contains(error, "a directory stands at byte"))
            << error;
      }
      // One that is not compressed reaches into what follows.
      EXPECT_EQ(error_at(first_directory[0] - 1).empty(), compression != 1);
      EXPECT_EQ(error_at(8), "");
    }
  }
}

TEST(TiffLayout, WithFewerBytesThanTheRowsNeedIsRejected) {
  const TempFolder folder;
  for (const std::uint32_t rows : {32U, 8U}) {
    TiffSample sample = blocks_sample(false, 1);
    sample.rows_per_strip = rows;
    write_tiff(folder.file("a.tif"), sample);
    const std::string whole = read_file(folder.file("a.tif"));
    const std::uint32_t needed = rows * 80;
    for (const std::uint32_t count : {0U, 10U, needed - 1}) {
      std::string bytes = whole;
      std::vector<std::uint32_t> counts(32 / rows, needed);
      counts.back() = count;
      if (counts.size() == 1) {
        set_number(bytes, TIFFTAG_STRIPBYTECOUNTS, count);
      } else {
        set_numbers(bytes, TIFFTAG_STRIPBYTECOUNTS, counts);
      }
      write_file(folder.file("a.tif"), bytes);
      expect_rejected(folder.file("a.tif"),
                      {"of page 0 has " + std::to_string(count) + " bytes, and its " +
                       std::to_string(rows) + " rows need " + std::to_string(needed)});
    }
  }
}

TEST(TiffLayout, OfOneStripNeedsNoByteCount) {
  const TempFolder folder;
  TiffSample sample = blocks_sample(false, 1);
  sample.rows_per_strip = 32;
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  constexpr std::uint16_t kOtherTag = 280;  // MinSampleValue, which keeps the order of tags
  bytes.replace(entry_of(bytes, TIFFTAG_STRIPBYTECOUNTS), 2, bytes_of<std::uint16_t>({kOtherTag}));
  write_file(folder.file("a.tif"), bytes);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), sample.pages[0]);
}

TEST(TiffLayout, WithMoreBytesThanTheRowsFillIsReadWithAWarning) {
  const TempFolder folder;
  for (const std::uint32_t rows : {32U, 20U}) {
    TiffSample sample = blocks_sample(false, 1);
    sample.rows_per_strip = rows;
    write_tiff(folder.file("a.tif"), sample);
    const std::string whole = read_file(folder.file("a.tif"));
    const auto warnings_with = [&](std::uint32_t last_count) {
      std::string bytes = whole + std::string(80 * 40, '\1');
      if (rows == 32) {
        set_number(bytes, TIFFTAG_STRIPBYTECOUNTS, last_count);
      } else {
        set_numbers(bytes, TIFFTAG_STRIPBYTECOUNTS, {80 * rows, last_count});
      }
      write_file(folder.file("a.tif"), bytes);
      const auto source = open_source({folder.file("a.tif")}, {});
      EXPECT_EQ(voxels_of(*source), sample.pages[0]);
      std::string told;
      for (const Warning& warning : source->warnings()) told += with_hints(warning);
      return told;
    };
    const std::uint32_t last_rows = rows == 32 ? 32 : 12;
    EXPECT_FALSE(contains(warnings_with(80 * last_rows), "bytes more"));
    EXPECT_FALSE(contains(warnings_with(80 * rows), "bytes more")) << "rows behind the page";
    EXPECT_FALSE(contains(warnings_with(80 * rows + 3), "bytes more")) << "rounded up";
    EXPECT_TRUE(contains(warnings_with(80 * rows + 4),
                         std::to_string(80 * (rows - last_rows) + 4) + " bytes more"));
  }
}

TEST(TiffLayout, WithBlocksOfWhichNothingIsStoredHasZerosThere) {
  const TempFolder folder;
  for (const bool has_tiles : {false, true}) {
    for (const std::uint16_t compression : std::array<std::uint16_t, 3>{1, 5, 8}) {
      TiffSample sample = blocks_sample(has_tiles, compression);
      write_tiff(folder.file("a.tif"), sample);
      std::string bytes = read_file(folder.file("a.tif"));
      const BlockTags tags = tags_of(has_tiles);
      for (const std::uint16_t tag : {tags.offsets, tags.byte_counts}) {
        std::vector<std::uint32_t> list = list_in(bytes, tag);
        list[1] = 0;
        set_numbers(bytes, tag, list);
      }
      write_file(folder.file("a.tif"), bytes);
      std::string expected = sample.pages[0];
      for (std::size_t row = 0; row < 32; ++row) {
        for (std::size_t x = 0; x < 40; ++x) {
          const bool is_absent = has_tiles ? row < 16 && x >= 16 && x < 32 : row / 8 == 1;
          if (is_absent) expected.replace((row * 40 + x) * 2, 2, 2, '\0');
        }
      }
      const auto source = open_source({folder.file("a.tif")}, {});
      EXPECT_EQ(voxels_of(*source), expected) << has_tiles << " " << compression;
      ASSERT_FALSE(source->warnings().empty());
      std::string told;
      for (const Warning& warning : source->warnings()) told += with_hints(warning);
      EXPECT_TRUE(contains(told, "nothing is stored")) << told;
    }
  }
}

TEST(TiffLayout, WithBlocksThatStandForAnotherValueThan0IsRejected) {
  const TempFolder folder;
  for (const std::string value : {"0", "0.0 ", "-9999", "nan"}) {
    TiffSample sample = blocks_sample(false, 1);
    sample.tags = {{42113, TIFF_ASCII, static_cast<std::uint32_t>(value.size() + 1), value}};
    write_tiff(folder.file("a.tif"), sample);
    std::string bytes = read_file(folder.file("a.tif"));
    for (const std::uint16_t tag : {TIFFTAG_STRIPOFFSETS, TIFFTAG_STRIPBYTECOUNTS}) {
      std::vector<std::uint32_t> list = list_in(bytes, tag);
      list[3] = 0;
      set_numbers(bytes, tag, list);
    }
    write_file(folder.file("a.tif"), bytes);
    if (value.starts_with('0')) {
      EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})),
                sample.pages[0].substr(0, 24 * 80) + std::string(8 * 80, '\0'));
    } else {
      expect_rejected(folder.file("a.tif"), {"1 strip or tile of page 0", "\"" + value + "\""});
    }
  }
}

TEST(TiffLayout, WithTilesOfSeveralPlanesIsRejected) {
  const TempFolder folder;
  TiffSample sample = blocks_sample(true, 1);
  constexpr std::uint16_t kStandIn = 65001;
  sample.tags = {{kStandIn, TIFF_LONG, 1, bytes_of<std::uint32_t>({2})}};
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  bytes.replace(entry_of(bytes, kStandIn), 2, bytes_of<std::uint16_t>({TIFFTAG_TILEDEPTH}));
  write_file(folder.file("a.tif"), bytes);
  expect_rejected(folder.file("a.tif"), {"a page of several planes", "TileDepth"});
}

TEST(TiffLayout, WithAPredictorOfAnyTypeOfIntegersHasItUndone) {
  const TempFolder folder;
  for (const int compression : {COMPRESSION_LZW, COMPRESSION_ADOBE_DEFLATE, COMPRESSION_ZSTD}) {
    TiffSample sample = blocks_sample(false, static_cast<std::uint16_t>(compression));
    sample.predictor = 2;
    write_tiff(folder.file("a.tif"), sample);
    const std::string whole = read_file(folder.file("a.tif"));
    const std::size_t at = entry_of(whole, TIFFTAG_PREDICTOR);
    for (const std::uint16_t type : std::array<std::uint16_t, 7>{1, 3, 4, 6, 8, 9, 13}) {
      std::string bytes = whole;
      bytes.replace(at + 2, 2, bytes_of<std::uint16_t>({type}));
      write_file(folder.file("a.tif"), bytes);
      try {
        EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), sample.pages[0])
            << compression << " " << type;
      } catch (const Error& error) {
        EXPECT_TRUE(contains(error, "redictor")) << with_hints(error);
        EXPECT_EQ(type, 13) << with_hints(error);
      }
    }
    for (const std::uint16_t count : std::array<std::uint16_t, 2>{0, 2}) {
      std::string bytes = whole;
      bytes.replace(at + 4, 2, bytes_of<std::uint16_t>({count}));
      write_file(folder.file("a.tif"), bytes);
      expect_rejected(folder.file("a.tif"), {"tag 317 (Predictor)", "one expected"});
    }
  }
}

TEST(TiffLayout, WithATagOfSeveralNumbersInPlaceOfOneIsRejected) {
  const TempFolder folder;
  for (const bool has_tiles : {false, true}) {
    TiffSample sample = blocks_sample(has_tiles, 1);
    sample.orientations = {1};
    write_tiff(folder.file("a.tif"), sample);
    const std::string whole = read_file(folder.file("a.tif"));
    std::vector<std::uint16_t> tags = {TIFFTAG_IMAGEWIDTH,      TIFFTAG_IMAGELENGTH,
                                       TIFFTAG_PHOTOMETRIC,     TIFFTAG_ORIENTATION,
                                       TIFFTAG_SAMPLESPERPIXEL, TIFFTAG_PLANARCONFIG};
    if (has_tiles) tags.insert(tags.end(), {TIFFTAG_TILEWIDTH, TIFFTAG_TILELENGTH});
    if (!has_tiles) tags.push_back(TIFFTAG_ROWSPERSTRIP);
    for (const std::uint16_t tag : tags) {
      for (const std::uint16_t count : std::array<std::uint16_t, 2>{0, 2}) {
        std::string bytes = whole;
        bytes.replace(entry_of(whole, tag) + 4, 2, bytes_of<std::uint16_t>({count}));
        write_file(folder.file("a.tif"), bytes);
        EXPECT_THROW(open_source({folder.file("a.tif")}, {}), Error) << tag << " " << count;
      }
      std::string bytes = whole;
      bytes.replace(entry_of(whole, tag) + 2, 2, bytes_of<std::uint16_t>({TIFF_FLOAT}));
      write_file(folder.file("a.tif"), bytes);
      EXPECT_THROW(open_source({folder.file("a.tif")}, {}), Error) << tag;
    }
  }
}

}  // namespace
}  // namespace octavo::testing
