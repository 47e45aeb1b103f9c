#include "octavo/io/source/jpeg_completeness.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace octavo::testing {
namespace {

using namespace std::string_literals;

constexpr const char* kStart = "\xff\xd8";
constexpr const char* kEnd = "\xff\xd9";
constexpr std::uint8_t kLossless = 0xc3;
constexpr std::uint8_t kSequential = 0xc0;
constexpr std::uint8_t kProgressive = 0xc2;
constexpr std::array<std::uint8_t, 17> kWidths = {0, 1,  2,  3,  4,  5,  6,  7, 8,
                                                  9, 10, 11, 12, 13, 14, 15, 16};
// Ends of blocks, long runs, and runs of 0 to 9 before numbers of several widths.
constexpr std::array<std::uint8_t, 17> kRuns = {0x01, 0x00, 0x11, 0x02, 0xf0, 0x23,
                                                0x31, 0x04, 0x52, 0x05, 0x66, 0x07,
                                                0x98, 0x09, 0x0a, 0xf1, 0x8f};

bool is_whole(std::string_view picture, std::string_view tables = {}) {
  return is_whole_jpeg(std::as_bytes(std::span(tables)), std::as_bytes(std::span(picture)));
}

std::string segment(std::uint8_t mark, const std::string& body) {
  const std::size_t length = body.size() + 2;
  return "\xff"s + static_cast<char>(mark) + static_cast<char>(length >> 8) +
         static_cast<char>(length) + body;
}

/// A table of 17 codes: one of each length from 2 to 15, three of 16.
std::string table(std::uint8_t place, const std::array<std::uint8_t, 17>& symbols) {
  std::string body(1, static_cast<char>(place));
  body += "\0\1\1\1\1\1\1\1\1\1\1\1\1\1\1\3"s;
  return segment(0xc4, body + std::string(symbols.begin(), symbols.end()));
}

/// The bits of a scan, with zeros behind bytes that look like marks.
class ScanWriter {
 public:
  void put(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) {
      last_ = last_ << 1 | (value >> i & 1U);
      if (++bit_count_ == 8) close();
    }
  }
  /// Code `index` of the table above, then as many random bits as given.
  void put_code(std::size_t index, int width) {
    std::uint32_t code = 0;
    int length = 2;
    for (std::size_t i = 0; i < index && length < 16; ++i, ++length) code = (code + 1) << 1;
    if (index > 14) code += static_cast<std::uint32_t>(index - 14);
    put(code, length);
    put(static_cast<std::uint32_t>(random_()), width);
  }
  void fill_up() {
    while (bit_count_ > 0) put(1, 1);
  }
  void add(const std::string& mark) { bytes_ += mark; }
  const std::string& bytes() const { return bytes_; }
  std::size_t pick(std::size_t count) { return random_() % count; }

 private:
  void close() {
    bytes_ += static_cast<char>(last_);
    if ((last_ & 0xffU) == 0xffU) bytes_ += '\0';
    last_ = 0;
    bit_count_ = 0;
  }

  std::mt19937 random_{7};
  std::string bytes_;
  std::uint32_t last_ = 0;
  int bit_count_ = 0;
};

void put_unit(ScanWriter& scan, std::uint8_t process) {
  if (process == kLossless) {
    const std::size_t index = scan.pick(kWidths.size());
    return scan.put_code(index, index == 16 ? 0 : kWidths[index]);
  }
  const std::size_t first = scan.pick(12);
  scan.put_code(first, kWidths[first]);
  for (unsigned i = 1; i < 64; ++i) {
    std::size_t index = scan.pick(kRuns.size());
    if (i + (kRuns[index] >> 4) > 63) index = 1;
    scan.put_code(index, kRuns[index] & 15);
    if (kRuns[index] == 0) return;
    i += static_cast<unsigned>(kRuns[index] >> 4);
  }
}

/// What a picture is made of. Factors are those of its components, across and down in one byte.
struct Picture {
  std::uint8_t process = kLossless;
  std::uint16_t columns = 13;
  std::uint16_t rows = 9;
  std::string factors = "\x11"s;
  bool is_interleaved = true;
  int interval = 0;
  std::vector<int> units;  ///< of each scan, counted by hand
  int units_together = 1;  ///< between which no restart stands
};

std::string frame(const Picture& picture) {
  std::string body = "\x08"s;
  for (const std::uint16_t size : {picture.rows, picture.columns}) {
    body += static_cast<char>(size >> 8);
    body += static_cast<char>(size);
  }
  body += static_cast<char>(picture.factors.size());
  for (std::size_t i = 0; i < picture.factors.size(); ++i) {
    body += static_cast<char>(i + 1) + picture.factors.substr(i, 1) + '\0';
  }
  return segment(picture.process, body);
}

std::string scan_head(std::size_t first, std::size_t count) {
  std::string body(1, static_cast<char>(count));
  for (std::size_t i = first; i < first + count; ++i) body += static_cast<char>(i + 1) + "\0"s;
  return segment(0xda, body + "\1\0\0"s);
}

const std::string kTables = table(0x00, kWidths) + table(0x10, kRuns);

/// The picture up to its last value, without the mark of the end.
std::string written(const Picture& picture, const std::string& tables = kTables) {
  std::string bytes = kStart + tables + frame(picture);
  if (picture.interval > 0) {
    bytes += segment(0xdd, "\0"s + static_cast<char>(picture.interval));
  }
  ScanWriter scan;
  for (std::size_t i = 0; i < picture.units.size(); ++i) {
    scan.add(picture.is_interleaved ? scan_head(0, picture.factors.size()) : scan_head(i, 1));
    int restarts = 0;
    for (int unit = 0; unit < picture.units[i]; ++unit) {
      const int between = picture.interval * picture.units_together;
      if (between > 0 && unit > 0 && unit % between == 0) {
        scan.fill_up();
        scan.add("\xff"s + static_cast<char>(0xd0 + restarts++ % 8));
      }
      put_unit(scan, picture.process);
    }
    scan.fill_up();
  }
  return bytes + scan.bytes();
}

const std::vector<Picture> kPictures = {
    {.units = {13 * 9}},
    {.interval = 13, .units = {13 * 9}},
    {.factors = "\x22"s, .units = {13 * 9}},  // of one component factors mean nothing
    {.factors = "\x11\x11\x11"s, .units = {3 * 13 * 9}},
    {.process = kSequential, .units = {2 * 2}},
    {.process = 0xc1, .columns = 65, .rows = 31, .interval = 2, .units = {9 * 4}},
    {.process = kSequential, .columns = 40, .rows = 20, .factors = "\x22\x11\x11"s, .interval = 1,
     .units = {3 * 2 * 6}, .units_together = 6},
    {.process = kSequential, .columns = 41, .rows = 25, .factors = "\x22\x11\x11"s,
     .is_interleaved = false, .interval = 2, .units = {6 * 4, 3 * 2, 3 * 2}},
};

TEST(JpegCompleteness, EveryCutThatLosesAValueIsTold) {
  for (std::size_t i = 0; i < kPictures.size(); ++i) {
    const std::string whole = written(kPictures[i]);
    EXPECT_TRUE(is_whole(whole)) << i;
    EXPECT_TRUE(is_whole(whole + kEnd)) << i;
    for (std::size_t length = 0; length < whole.size(); ++length) {
      const std::string cut = whole.substr(0, length);
      ASSERT_FALSE(is_whole(cut)) << i << " " << length;
      ASSERT_FALSE(is_whole(cut + kEnd)) << i << " " << length;
      ASSERT_FALSE(is_whole(cut + kEnd + "behind it")) << i << " " << length;
    }
  }
}

TEST(JpegCompleteness, ZerosInPlaceOfTheEndAreNoValues) {
  for (const Picture& picture : kPictures) {
    const std::string whole = written(picture);
    EXPECT_TRUE(is_whole(whole + std::string(3, '\0')));
    EXPECT_TRUE(is_whole(whole + std::string(9, '\0') + kEnd));
    for (const std::size_t lost : {9U, 20U}) {
      const std::string cut = whole.substr(0, whole.size() - lost);
      EXPECT_FALSE(is_whole(cut + std::string(lost + 2, '\0'))) << lost;
    }
  }
}

TEST(JpegCompleteness, TablesMayStandElsewhere) {
  for (const Picture& picture : kPictures) {
    const std::string whole = written(picture, "");
    const std::string tables = kStart + kTables + kEnd;
    EXPECT_TRUE(is_whole(whole, tables));
    EXPECT_FALSE(is_whole(whole.substr(0, whole.size() - 2), tables));
    // Where they are known to the decoder alone, the mark of the end is all there is to ask for.
    EXPECT_FALSE(is_whole(whole));
    EXPECT_TRUE(is_whole(whole + kEnd));
  }
}

TEST(JpegCompleteness, OfOtherProcessesNeedsTheMarkOfTheEnd) {
  Picture picture = kPictures[4];
  picture.process = kProgressive;
  const std::string bytes = written(picture);
  EXPECT_FALSE(is_whole(bytes));
  EXPECT_TRUE(is_whole(bytes + kEnd));
  EXPECT_FALSE(is_whole(kStart + kTables + kEnd));
}

TEST(JpegCompleteness, RestartsStandInTheirOrder) {
  const std::string whole = written(kPictures[1]);
  std::string swapped = whole;
  swapped[whole.find("\xff\xd0") + 1] = '\xd1';
  EXPECT_FALSE(is_whole(swapped));
  // Bytes that nothing needs may stand before them.
  std::string padded = whole;
  padded.insert(whole.find("\xff\xd0"), "\0\0\xff"s);
  EXPECT_TRUE(is_whole(padded));
}

TEST(JpegCompleteness, OfDamagedBytesIsFoundWithoutHarm) {
  std::mt19937 random(3);
  for (const Picture& picture : kPictures) {
    const std::string whole = written(picture) + kEnd;
    for (int i = 0; i < 300; ++i) {
      std::string bytes = whole;
      for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
      is_whole(bytes.substr(0, random() % (bytes.size() + 1)));
    }
  }
  Picture huge = kPictures[0];
  huge.columns = 65535;
  huge.rows = 65535;
  EXPECT_FALSE(is_whole(written(huge)));
  EXPECT_FALSE(is_whole(std::string(1 << 20, '\xff')));
  EXPECT_FALSE(is_whole(""));
}

}  // namespace
}  // namespace octavo::testing
