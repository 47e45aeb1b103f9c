// The smallest interesting file: as the writer makes it, as it is kept, as docs/format.md shows it.
// Run with OCTAVO_WRITE_GOLDEN=1 to write the kept file and the listing anew before a format is
// frozen.
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <iterator>

#include "golden/listing.h"
#include "octavo/file/verify.h"
#include "support/sample_file.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

using namespace octavo::testing;

const std::string kGoldenPath = source_folder() + "/tests/golden/v1/minimal.8vo";
const std::string kFormatPath = source_folder() + "/docs/format.md";
const std::string kListingStart = "<!-- listing of minimal.8vo -->\n```text\n";
const std::string kListingEnd = "```\n";

std::string text_of(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

SampleVolume minimal_volume() {
  SampleVolume volume = make_sample({2, 2, 2}, VoxelType::uint8, Pattern::gradient);
  volume.samples[0] = {10, 12, 11, 13, 9, 200, 10, 11};
  volume.description.metadata = Metadata::read("{}");
  return volume;
}

std::vector<std::uint8_t> golden_bytes() {
  const std::string text = text_of(kGoldenPath);
  return {text.begin(), text.end()};
}

void write_anew() {
  SampleVolume volume = minimal_volume();
  const std::vector<std::uint8_t> bytes = sample_file_bytes(volume);
  std::ofstream(kGoldenPath, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()),
             static_cast<std::streamsize>(bytes.size()));
  std::string format = text_of(kFormatPath);
  const std::size_t start = format.find(kListingStart) + kListingStart.size();
  format.replace(start, format.find(kListingEnd, start) - start, annotated_listing(bytes));
  std::ofstream(kFormatPath, std::ios::binary) << format;
}

class MinimalFile : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (std::getenv("OCTAVO_WRITE_GOLDEN") != nullptr) write_anew();
  }
};

TEST_F(MinimalFile, IsWhatTheWriterMakes) {
  SampleVolume volume = minimal_volume();
  EXPECT_EQ(sample_file_bytes(volume), golden_bytes());
}

TEST_F(MinimalFile, GivesItsVoxelsBackAtEveryLevel) {
  const auto reader = open_bytes(golden_bytes());
  const Bytes voxels = {10, 12, 11, 13, 9, 200, 10, 11};
  EXPECT_EQ(read_samples(*reader, {{0, 0, 0}, {2, 2, 2}}, 0), voxels);
  const int mean = read_samples(*reader, {{0, 0, 0}, {1, 1, 1}}, 1)[0];
  EXPECT_NEAR(mean, 276 / 8.0, 1.5);
}

TEST_F(MinimalFile, StandsInTheFormatByteByByte) {
  const std::string format = text_of(kFormatPath);
  const std::size_t mark = format.find(kListingStart);
  ASSERT_NE(mark, std::string::npos);
  const std::size_t start = mark + kListingStart.size();
  EXPECT_EQ(format.substr(start, format.find(kListingEnd, start) - start),
            annotated_listing(golden_bytes()));
}

TEST_F(MinimalFile, EveryFlippedBitAndTruncationIsDetected) {
  const std::vector<std::uint8_t> good = golden_bytes();
  NoProgress progress;
  for (std::size_t bit = 0; bit < 8 * good.size(); ++bit) {
    std::vector<std::uint8_t> bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1 << bit % 8);
    try {
      EXPECT_FALSE(verify_file(byte_source_of(bad, "flip"), {}, progress).is_sound()) << bit;
    } catch (const Error&) {
      continue;
    }
  }
  for (std::size_t length = 0; length < good.size(); ++length) {
    EXPECT_THROW(open_bytes({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}),
                 Error);
  }
}

}  // namespace
}  // namespace octavo
