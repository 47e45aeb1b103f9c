#include <gtest/gtest.h>
#include <tiffio.h>

#include <algorithm>

#include "octavo/io/source/natural_order.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

std::string counted(std::size_t bytes, int start) {
  std::string text;
  for (std::size_t i = 0; i < bytes; ++i)
    text += static_cast<char>((start + static_cast<int>(i) * 7) % 251);
  return text;
}

TEST(SourceStack, NaturalOrderIsThatOfTheNumbers) {
  std::vector<std::string> names = {"b 10",
                                    "b 9",
                                    "a2",
                                    "a10",
                                    "b 010",
                                    "a",
                                    "b 100000000000000000000001",
                                    "b 100000000000000000000000"};
  std::sort(names.begin(), names.end(), natural_less);
  const std::vector<std::string> expected = {"a",
                                             "a2",
                                             "a10",
                                             "b 9",
                                             "b 010",
                                             "b 10",
                                             "b 100000000000000000000000",
                                             "b 100000000000000000000001"};
  EXPECT_EQ(names, expected);
}

TEST(SourceStack, NumbersThatSkipAreRefusedWithBothNamesOrIgnored) {
  for (const bool is_tiff : {true, false}) {
    const TempFolder folder;
    std::string expected;
    for (const int number : {8, 9, 11, 12}) {
      const std::string name = "half MB_ " + std::to_string(number);
      TiffSample sample;
      sample.pages = {counted(12, number)};
      expected += sample.pages[0];
      if (is_tiff) write_tiff(folder.file(name + ".tif"), sample);
      if (!is_tiff) write_png(folder.file(name + ".png"), 4, 3, 8, 0, sample.pages[0]);
    }
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const char* word : {"half MB_ 9.", "half MB_ 11.", "1 file is missing", "--on-gap"}) {
      EXPECT_TRUE(contains(error.what(), word)) << error.what();
    }
    SourceOptions options;
    options.on_gap = GapPolicy::ignore;
    const auto source = open_source({folder.path()}, options);
    EXPECT_EQ(voxels_of(*source), expected);
    EXPECT_TRUE(contains(source->description().metadata_json, "\"ignored_number_gaps\":1"));
    EXPECT_TRUE(contains(source->warnings()[0], "half MB_ 11."));
    options.on_gap = GapPolicy::fill;
    EXPECT_EQ(source_error({folder.path()}, options).kind(), ErrorKind::invalid_argument);
  }
}

TEST(SourceStack, TiffFilesAreTakenInNaturalOrder) {
  const TempFolder folder;
  std::string expected;
  for (int z = 0; z < 12; ++z) {
    TiffSample sample;
    sample.pages = {counted(12, z)};
    expected += sample.pages[0];
    write_tiff(folder.file("a slice " + std::to_string(z) + ".tif"), sample);
  }
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().size, (Size3{4, 3, 12}));
  EXPECT_TRUE(contains(source->description().metadata_json, "\"spacing_known\":false"));
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "--spacing"));
  EXPECT_EQ(voxels_of(*source), expected);
}

/// Ways to store the same pages.
struct Layout {
  const char* name;
  std::uint16_t bits;
  std::uint16_t format;
  std::uint16_t compression;
  std::uint32_t tile;
  std::uint32_t rows_per_strip;
  bool big;
  VoxelType type;
};

class SourceTiffLayout : public ::testing::TestWithParam<Layout> {};

TEST_P(SourceTiffLayout, GivesTheStoredVoxels) {
  const Layout& layout = GetParam();
  const TempFolder folder;
  TiffSample sample;
  sample.width = 37;
  sample.height = 21;
  sample.bits = layout.bits;
  sample.format = layout.format;
  sample.compression = layout.compression;
  sample.tile = layout.tile;
  sample.rows_per_strip = layout.rows_per_strip;
  sample.big = layout.big;
  for (int z = 0; z < 3; ++z) sample.pages.push_back(counted(37 * 21 * layout.bits / 8U, z));
  write_tiff(folder.file("a.tif"), sample);
  const auto source = open_source({folder.file("a.tif")}, {});
  EXPECT_EQ(source->description().type, layout.type);
  EXPECT_EQ(voxels_of(*source), sample.pages[0] + sample.pages[1] + sample.pages[2]);
}

TEST(SourceStack, JpegInATiffIsToldAsALoss) {
  const TempFolder folder;
  TiffSample sample;
  sample.width = 16;
  sample.height = 16;
  sample.compression = COMPRESSION_JPEG;
  sample.rows_per_strip = 16;
  sample.pages = {counted(256, 1)};
  write_tiff(folder.file("a.tif"), sample);
  const auto source = open_source({folder.file("a.tif")}, {});
  EXPECT_TRUE(contains(source->description().metadata_json, "\"lossy_source\":true"));
}

INSTANTIATE_TEST_SUITE_P(
    Tiff, SourceTiffLayout,
    ::testing::Values(
        Layout{"U8", 8, 1, COMPRESSION_NONE, 0, 0, false, VoxelType::uint8},
        Layout{"I8", 8, 2, COMPRESSION_NONE, 0, 5, false, VoxelType::int8},
        Layout{"U16Lzw", 16, 1, COMPRESSION_LZW, 0, 4, false, VoxelType::uint16},
        Layout{"I16Deflate", 16, 2, COMPRESSION_ADOBE_DEFLATE, 0, 4, false, VoxelType::int16},
        Layout{"I32Tiled", 32, 2, COMPRESSION_NONE, 16, 0, false, VoxelType::int32},
        Layout{"U32Big", 32, 1, COMPRESSION_NONE, 0, 7, true, VoxelType::uint32},
        Layout{"F32", 32, 3, COMPRESSION_NONE, 0, 0, false, VoxelType::float32},
        Layout{"U16TiledDeflateBig", 16, 1, COMPRESSION_ADOBE_DEFLATE, 16, 0, true,
               VoxelType::uint16},
        Layout{"U8PackBits", 8, 1, COMPRESSION_PACKBITS, 0, 3, false, VoxelType::uint8}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(SourceStack, ImageJSpacingIsUsed) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = "ImageJ=1.53t\nimages=2\nslices=2\nunit=micron\nspacing=2.5\n";
  sample.resolution = 4;
  sample.pages = {counted(12, 0), counted(12, 1)};
  write_tiff(folder.file("a.tif"), sample);
  const auto source = open_source({folder.file("a.tif")}, {});
  EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[0], 0.00025);
  EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[2], 0.0025);
  EXPECT_TRUE(source->warnings().empty());
  SourceOptions options;
  options.spacing_mm = Point3{3, 4, 5};
  EXPECT_EQ(open_source({folder.file("a.tif")}, options)->description().geometry.spacing_mm,
            (Point3{3, 4, 5}));
}

/// A stack of two pages with a description.
std::unique_ptr<PlaneSource> described_tiff(const TempFolder& folder, const std::string& text,
                                            float resolution = 0, std::uint16_t unit = 1) {
  TiffSample sample;
  sample.description = text;
  sample.resolution = resolution;
  sample.resolution_unit = unit;
  sample.pages = {counted(12, 0), counted(12, 1)};
  write_tiff(folder.file("a.tif"), sample);
  return open_source({folder.file("a.tif")}, {});
}

TEST(SourceStack, ImageJSpacingIsInItsUnit) {
  const TempFolder folder;
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"micron", 1e-3}, {"\\u00B5m", 1e-3}, {"um", 1e-3}, {"mm", 1}, {"cm", 10},
           {"inch", 25.4}, {"nm", 1e-6}}) {
    const auto source =
        described_tiff(folder, "ImageJ=1.53t\nimages=2\nunit=" + unit + "\nspacing=2.5\n", 4);
    EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[0], mm / 4) << unit;
    EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[2], mm * 2.5) << unit;
  }
  for (const std::string unit : {"pixel", "pixels", ""}) {
    const auto source =
        described_tiff(folder, "ImageJ=1.53t\nimages=2\nunit=" + unit + "\nspacing=2.5\n", 4);
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "--spacing"));
  }
  const auto odd = described_tiff(folder, "ImageJ=1.53t\nunit=furlong\nspacing=2.5\n", 4);
  ASSERT_EQ(odd->warnings().size(), 2U);
  EXPECT_TRUE(contains(odd->warnings()[0], "furlong"));
}

TEST(SourceStack, ResolutionTagsAloneAreToldAndNotUsed) {
  const TempFolder folder;
  for (const auto& [unit, words] : std::vector<std::pair<std::uint16_t, std::string>>{
           {std::uint16_t{2}, "0.3527778 x 0.3527778 mm"}, {std::uint16_t{3}, "0.1388889"}}) {
    const auto source = described_tiff(folder, "", 72, unit);
    ASSERT_EQ(source->warnings().size(), 2U);
    EXPECT_TRUE(contains(source->warnings()[0], words)) << source->warnings()[0];
    EXPECT_TRUE(contains(source->warnings()[1], "--spacing"));
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{1, 1, 1}));
  }
}

TEST(SourceStack, ImageJCalibrationThatIsALineIsTheRescale) {
  const TempFolder folder;
  const std::string start = "ImageJ=1.53t\nimages=2\nunit=mm\nspacing=2\n";
  const auto signed_values =
      described_tiff(folder, start + "cf=0\nc0=-32768.0\nc1=1.0\nvunit=Gray Value\n", 1);
  EXPECT_EQ(signed_values->description().rescale, (Rescale{1, -32768}));
  EXPECT_FALSE(contains(signed_values->description().metadata_json, "unit\":"));
  const auto hounsfield =
      described_tiff(folder, start + "cf=0\nc0=-1024\nc1=0.25\nvunit=HU\n", 1);
  EXPECT_EQ(hounsfield->description().rescale, (Rescale{0.25, -1024}));
  EXPECT_TRUE(contains(hounsfield->description().metadata_json, "\"unit\":\"HU\""));
  const auto words =
      described_tiff(folder, start + "cf=0\nc0=-1024\nc1=0.25\nvunit=SECRET name\n", 1);
  EXPECT_FALSE(contains(words->description().metadata_json, "unit\":"));
  EXPECT_FALSE(contains(words->description().metadata_json, "SECRET"));
  const auto curve = described_tiff(folder, start + "cf=4\nc0=1\nc1=2\nc2=3\n", 1);
  EXPECT_EQ(curve->description().rescale, Rescale{});
  ASSERT_EQ(curve->warnings().size(), 1U);
  EXPECT_TRUE(contains(curve->warnings()[0], "function 4"));
}

TEST(SourceStack, OmeSpacingIsUsed) {
  const TempFolder folder;
  TiffSample sample;
  sample.description =
      "<?xml version=\"1.0\"?><OME><Image><Pixels SizeC=\"1\" SizeT=\"1\" PhysicalSizeX=\"0.5\" "
      "PhysicalSizeY=\"0.5\" PhysicalSizeZ=\"2\" PhysicalSizeZUnit=\"um\"></Pixels></Image></OME>";
  sample.pages = {counted(12, 0), counted(12, 1)};
  write_tiff(folder.file("a.ome.tif"), sample);
  EXPECT_EQ(open_source({folder.file("a.ome.tif")}, {})->description().geometry.spacing_mm,
            (Point3{0.0005, 0.0005, 0.002}));
}

TEST(SourceStack, TiffsThatAreNoVolumeAreRefused) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0), counted(12, 1)};
  sample.description = "ImageJ=1.53t\nimages=2\nchannels=2\n";
  write_tiff(folder.file("channels.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("channels.tif")}).what(), "2 channels"));
  sample.description = "ImageJ=1.53t\nimages=2\nframes=2\n";
  write_tiff(folder.file("frames.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("frames.tif")}).what(), "points in time"));
  sample.description = "ImageJ=1.53t\nimages=9\nslices=9\n";
  write_tiff(folder.file("lost.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("lost.tif")}).what(), "9 images, 2 pages"));
  sample = {};
  sample.samples = 3;
  sample.pages = {counted(36, 0)};
  write_tiff(folder.file("rgb.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("rgb.tif")}).what(), "3 channels (red, green"));
}

TEST(SourceStack, AnOddPlaneIsNamedWithBothSizesOrTypes) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a1.tif"), sample);
  sample.width = 6;
  sample.pages = {counted(18, 0)};
  write_tiff(folder.file("a2.tif"), sample);
  Error error = source_error({folder.path()});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_TRUE(contains(error.what(), "a2.tif is 6 x 3") && contains(error.what(), "4 x 3"))
      << error.what();
  sample.width = 4;
  sample.bits = 16;
  sample.pages = {counted(24, 0)};
  write_tiff(folder.file("a2.tif"), sample);
  error = source_error({folder.path()});
  EXPECT_TRUE(contains(error.what(), "uint16") && contains(error.what(), "uint8")) << error.what();
}

TEST(SourceStack, ATiffLargerThanItsTagsSayIsUnfoldedAsImageJWroteIt) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = "ImageJ=1.53t\nimages=3\nslices=3\n";
  sample.pages = {std::string(12, '\x5a')};
  write_tiff(folder.file("a.tif"), sample);
  // ImageJ puts the tags before the voxels; here the file grows until the planes fit behind the
  // first one.
  std::string bytes = read_file(folder.file("a.tif"));
  const std::size_t start = bytes.find(sample.pages[0]);
  if (bytes.size() < start + 36) bytes.resize(start + 36, '\x11');
  write_file(folder.file("a.tif"), bytes);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), bytes.substr(start, 36));
}

TEST(SourceStack, EveryTruncationOfATiffIsRefused) {
  const TempFolder folder;
  TiffSample sample;
  sample.compression = COMPRESSION_ADOBE_DEFLATE;
  sample.pages = {counted(12, 0), counted(12, 9)};
  write_tiff(folder.file("a.tif"), sample);
  const std::string whole = read_file(folder.file("a.tif"));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_file(folder.file("cut.tif"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file("cut.tif")}).kind(), ErrorKind::source_rejected) << length;
  }
}

TEST(SourceStack, PngPlanesGiveTheStoredVoxels) {
  const TempFolder folder;
  const std::vector<std::uint16_t> values = {0, 1, 256, 65535, 7, 40000};
  write_png(folder.file("p10.png"), 3, 2, 16, 0, bytes_of(values, true));
  write_png(folder.file("p9.png"), 3, 2, 16, 0, std::string(12, '\1'));
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().type, VoxelType::uint16);
  EXPECT_EQ(voxels_of(*source), std::string(12, '\1') + bytes_of(values));
}

/// A row of 8 grey levels, 0 or the largest one, in so many bits.
std::string black_and_white(int bits) {
  std::string row;
  for (int byte = 0; byte < bits; ++byte) row += static_cast<char>(bits == 1 ? 0x0f : 0);
  for (int byte = bits / 2; bits > 1 && byte < bits; ++byte) {
    row[static_cast<std::size_t>(byte)] = static_cast<char>(0xff);
  }
  return row;
}

TEST(SourceStack, PngPlanesOfSeveralDepthsAreScaledToOne) {
  const TempFolder folder;
  std::string expected;
  for (const int bits : {8, 1, 2, 4, 8}) {
    const std::string name = "p" + std::to_string(expected.size() / 8) + ".png";
    write_png(folder.file(name), 8, 1, bits, 0, black_and_white(bits));
    expected += std::string(4, '\0') + std::string(4, '\xff');
  }
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(voxels_of(*source), expected);
  EXPECT_TRUE(contains(source->warnings()[0], "1, 2, 4 and 8 bits")) << source->warnings()[0];
}

TEST(SourceStack, PngPlanesOfOneSmallDepthKeepTheirNumbers) {
  for (const auto& [bits, white] : {std::pair{1, 1}, {2, 3}, {4, 15}}) {
    const TempFolder folder;
    for (const char* name : {"p0.png", "p1.png"}) {
      write_png(folder.file(name), 8, 1, bits, 0, black_and_white(bits));
    }
    const auto source = open_source({folder.path()}, {});
    const std::string plane = std::string(4, '\0') + std::string(4, static_cast<char>(white));
    EXPECT_EQ(voxels_of(*source), plane + plane);
    EXPECT_TRUE(contains(source->warnings()[0], "0 to " + std::to_string(white)));
  }
}

TEST(SourceStack, PngsThatAreNoStackAreRefused) {
  const TempFolder folder;
  write_png(folder.file("a1.png"), 3, 2, 8, 0, counted(6, 0));
  write_png(folder.file("a2.png"), 2, 2, 8, 0, counted(4, 0));
  EXPECT_TRUE(contains(source_error({folder.path()}).what(), "2 x 2"));
  write_png(folder.file("rgb.png"), 2, 2, 8, 2, counted(12, 0));
  EXPECT_TRUE(contains(source_error({folder.file("rgb.png")}).what(), "3 channels"));
  const std::string whole = read_file(folder.file("a1.png"));
  for (std::size_t length = 8; length < whole.size(); ++length) {
    write_file(folder.file("cut.png"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file("cut.png")}).kind(), ErrorKind::source_rejected) << length;
  }
}

TEST(SourceStack, RawPlanesInOneFileOrMany) {
  const TempFolder folder;
  const std::vector<std::int16_t> values = {1, -2, 300, -32768, 5, 6, 7, 32767};
  SourceOptions options;
  options.raw = parse_raw_layout("2,2,2,int16:be");
  write_file(folder.file("all.raw"), bytes_of(values, true));
  EXPECT_EQ(voxels_of(*open_source({folder.file("all.raw")}, options)), bytes_of(values));
  write_file(folder.file("planes/z10"), bytes_of<std::int16_t>({5, 6, 7, 32767}, true));
  write_file(folder.file("planes/z9"), bytes_of<std::int16_t>({1, -2, 300, -32768}, true));
  EXPECT_EQ(voxels_of(*open_source({folder.file("planes")}, options)), bytes_of(values));
  write_file(folder.file("all.raw"), std::string(15, 'x'));
  const Error error = source_error({folder.file("all.raw")}, options);
  EXPECT_TRUE(contains(error.what(), "16 bytes") && contains(error.what(), "15")) << error.what();
}

TEST(SourceStack, RawLayoutsThatMakeNoSenseAreRefused) {
  for (const char* text :
       {"", "1,2,3", "1,2,3,4,5", "0,2,3,uint8", "-1,2,3,uint8", "2,2,2,float64", "2,2,2097153,u8",
        "2,2,x,u8", "2,2,2,u8:xx", "99999999999999999999,1,1,u8"}) {
    EXPECT_EQ(error_of([&] { parse_raw_layout(text); }).kind(), ErrorKind::invalid_argument)
        << text;
  }
}

TEST(SourceStack, MissingAndUnreadablePathsAreIoErrors) {
  const TempFolder folder;
  EXPECT_EQ(source_error({folder.file("nothing.tif")}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({"/dev/null"}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({folder.path()}).kind(), ErrorKind::source_rejected);
  EXPECT_EQ(source_error({}).kind(), ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo::testing
