#include "octavo/io/dicom/dicom_mosaic.h"

#include <gtest/gtest.h>

#include <map>

#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

using Entries = std::vector<std::pair<std::string, std::vector<std::string>>>;

std::string padded(std::string text, std::size_t size) {
  text.resize(size);
  return text;
}

std::string numbers(const std::vector<std::int32_t>& values) { return bytes_of(values); }

/// A scanner's header in its newer or its older form. Each entry has six items, as scanners write.
std::string scanner_header(const Entries& entries, bool is_newer) {
  constexpr std::int32_t kItems = 6;
  const auto count = static_cast<std::int32_t>(entries.size());
  std::string bytes = is_newer ? std::string("SV10\4\3\2\1", 8) : "";
  bytes += numbers({count, 77});
  for (const auto& [name, values] : entries) {
    bytes += padded(name, 64) + numbers({static_cast<std::int32_t>(values.size())}) + "DS" +
             std::string(2, '\0') + numbers({3, kItems, 77});
    for (std::size_t i = 0; i < kItems; ++i) {
      const std::string value = i < values.size() ? values[i] + std::string(1, '\0') : "";
      const auto length = static_cast<std::int32_t>(value.size());
      bytes += is_newer ? numbers({length, length, 77, length})
                        : numbers({length + kItems, length, 77, length});
      bytes += padded(value, (value.size() + 3) / 4 * 4);
    }
  }
  return bytes;
}

/// What tests change of a mosaic of 5 tiles of 3 x 2 voxels in a picture of 9 x 6.
struct MosaicSample {
  Entries entries = {{"EchoLinePosition", {"32"}},
                     {"NumberOfImagesInMosaic", {"5"}},
                     {"SliceNormalVector", {"0.0", "0.0", "1.0"}},
                     {"ProtocolSliceNumber", {"0"}}};
  bool is_newer = true;
  bool has_header = true;
  std::string owner = "SIEMENS CSA HEADER";
  std::string spacing = "3.5";
};

/// The voxel at column x and row y of the picture is 16 y + x.
DicomElements mosaic_elements(const MosaicSample& sample) {
  DicomElements elements = ct_elements(9, 6, 8, 100);
  elements.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\M\\MOSAIC");
  elements.set(0x00080060, "CS", "MR");
  if (!sample.spacing.empty()) elements.set(0x00180088, "DS", sample.spacing);
  if (sample.has_header) {
    elements.set(0x00290011, "LO", sample.owner);
    elements.set(0x00291110, "OB", scanner_header(sample.entries, sample.is_newer));
  }
  std::string voxels;
  for (int y = 0; y < 6; ++y) {
    for (int x = 0; x < 9; ++x) voxels += static_cast<char>(16 * y + x);
  }
  elements.set(0x7fe00010, "OB", voxels);
  return elements;
}

/// The voxels of tile `index` in that picture.
std::string tile(int index) {
  std::string voxels;
  for (int y = 0; y < 2; ++y) {
    for (int x = 0; x < 3; ++x) {
      voxels += static_cast<char>(16 * (index / 3 * 2 + y) + index % 3 * 3 + x);
    }
  }
  return voxels;
}

class SourceDicomMosaic : public ::testing::Test {
 protected:
  std::unique_ptr<PlaneSource> open(const MosaicSample& sample) {
    mosaic_elements(sample).write(path_, kExplicitLittle);
    return open_source({path_}, {});
  }
  void expect_rejected(const MosaicSample& sample, const std::string& words) {
    mosaic_elements(sample).write(path_, kExplicitLittle);
    octavo::testing::expect_rejected(path_, {"mosaic", words, "dcm2niix"});
  }

  TempFolder folder_;
  std::string path_ = folder_.file("a.dcm");
};

TEST_F(SourceDicomMosaic, IsTheVolumeOfItsTiles) {
  for (const bool is_newer : {true, false}) {
    MosaicSample sample;
    sample.is_newer = is_newer;
    const auto source = open(sample);
    const VolumeDescription& volume = source->description();
    EXPECT_EQ(volume.size, (Size3{3, 2, 5}));
    EXPECT_EQ(volume.geometry.spacing_mm, (Point3{0.5, 0.5, 3.5}));
    // The picture of 9 x 6 voxels and its first tile of 3 x 2 have one center.
    EXPECT_EQ(volume.geometry.origin_mm, (Point3{1.5, 1, 100}));
    EXPECT_EQ(voxels_of(*source), tile(0) + tile(1) + tile(2) + tile(3) + tile(4));
    EXPECT_TRUE(source->warnings().empty());
  }
}

TEST_F(SourceDicomMosaic, OfTheOtherNormalIsStackedTheOtherWay) {
  MosaicSample sample;
  sample.entries[2].second = {"0", "0", "-1"};
  const auto source = open(sample);
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{1.5, 1, 100 - 4 * 3.5}));
  EXPECT_EQ(voxels_of(*source), tile(4) + tile(3) + tile(2) + tile(1) + tile(0));
}

TEST_F(SourceDicomMosaic, OfUnknownOrContradictoryLayoutIsRejected) {
  MosaicSample sample;
  sample.has_header = false;
  expect_rejected(sample, "without the header of its scanner");
  sample = {};
  sample.owner = "SIEMENS MEDCOM HEADER";
  expect_rejected(sample, "without the header of its scanner");
  sample = {};
  sample.spacing.clear();
  expect_rejected(sample, "Spacing Between Slices");
  using Change = std::pair<std::size_t, std::vector<std::string>>;
  for (const auto& [change, words] : std::map<Change, std::string>{
           {{1, {}}, "how many they are"},
           {{1, {"x"}}, "how many they are"},
           {{1, {"-1"}}, "how many they are"},
           {{1, {"nan"}}, "how many they are"},
           {{1, {"1e18"}}, "how many they are"},
           {{1, {"10"}}, "no whole tiles"},
           {{2, {"0", "0"}}, "how many they are"},
           {{2, {"0", "1", "0"}}, "another normal"},
           {{3, {"4"}}, "reverse order"}}) {
    sample = {};
    sample.entries[change.first].second = change.second;
    expect_rejected(sample, words);
  }
}

TEST_F(SourceDicomMosaic, OfMoreSlicesThanAnyScannerTakesIsRejected) {
  MosaicSample sample;
  sample.entries[1].second = {"4225"};
  DicomElements elements = mosaic_elements(sample);
  elements.set_number(0x00280010, 130);
  elements.set_number(0x00280011, 130);
  elements.set(0x7fe00010, "OB", std::string(130 * 130, 'a'));
  elements.write(path_, kExplicitLittle);
  octavo::testing::expect_rejected(path_, {"mosaic", "of 4225 slices", "at most 4096"});
}

TEST_F(SourceDicomMosaic, InSeveralFramesIsRejected) {
  DicomElements elements = mosaic_elements({});
  elements.set(0x00280008, "IS", "2");
  elements.set(0x7fe00010, "OB", std::string(2 * 9 * 6, 'a'));
  elements.write(path_, kExplicitLittle);
  octavo::testing::expect_rejected(path_, {"mosaic", "in several frames", "dcm2niix"});
}

TEST_F(SourceDicomMosaic, ADamagedHeaderIsRejectedWhereverItEnds) {
  const MosaicSample sample;
  const std::string header = scanner_header(sample.entries, true);
  DicomElements elements = mosaic_elements(sample);
  const std::size_t needed = header.find("ProtocolSliceNumber");
  for (std::size_t length = 0; length < needed; length += 2) {
    elements.set(0x00291110, "OB", header.substr(0, length));
    elements.write(path_, kExplicitLittle);
    EXPECT_EQ(source_error({path_}).kind(), ErrorKind::source_rejected) << length;
  }
}

}  // namespace
}  // namespace octavo::testing
