#include "octavo/io/images/tiff_source.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(TiffSource, FilesAreTakenInNaturalOrder) {
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
  EXPECT_TRUE(contains(source->description().metadata.text(), "\"spacing_known\":false"));
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "[spacing_mm]"));
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

class TiffSourceLayout : public ::testing::TestWithParam<Layout> {};

TEST_P(TiffSourceLayout, GivesTheStoredVoxels) {
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

TEST(TiffSource, JpegIsReportedAsALoss) {
  const TempFolder folder;
  TiffSample sample;
  sample.width = 16;
  sample.height = 16;
  sample.compression = COMPRESSION_JPEG;
  sample.rows_per_strip = 16;
  sample.pages = {counted(256, 1)};
  write_tiff(folder.file("a.tif"), sample);
  const auto source = open_source({folder.file("a.tif")}, {});
  EXPECT_TRUE(contains(source->description().metadata.text(), "\"lossy_source\":true"));
}

TEST(TiffSource, CompressionWithoutADecoderIsNamed) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 1)};
  write_tiff(folder.file("a.tif"), sample);
  const std::string whole = read_file(folder.file("a.tif"));
  const std::string entry = bytes_of<std::uint16_t>({TIFFTAG_COMPRESSION, 3, 1, 0, 1});
  ASSERT_NE(whole.find(entry), std::string::npos);
  for (const auto& [number, name] : std::vector<std::pair<std::uint16_t, std::string>>{
           {34712, "JPEG 2000 (34712)"}, {50002, "JPEG XL (50002)"}, {777, "kind 777"}}) {
    std::string bytes = whole;
    bytes.replace(whole.find(entry), entry.size(),
                  bytes_of<std::uint16_t>({TIFFTAG_COMPRESSION, 3, 1, 0, number}));
    write_file(folder.file("a.tif"), bytes);
    const Error error = source_error({folder.file("a.tif")});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, "compression of " + name)) << error.what();
  }
}

INSTANTIATE_TEST_SUITE_P(
    Tiff, TiffSourceLayout,
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

TEST(TiffSource, ImageJSpacingIsUsed) {
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

TEST(TiffSource, ImageJSpacingIsInItsUnit) {
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
    EXPECT_TRUE(contains(source->warnings()[0], "[spacing_mm]"));
  }
  const auto odd = described_tiff(folder, "ImageJ=1.53t\nunit=furlong\nspacing=2.5\n", 4);
  ASSERT_EQ(odd->warnings().size(), 2U);
  EXPECT_TRUE(contains(odd->warnings()[0], "furlong"));
}

TEST(TiffSource, ResolutionTagsAloneAreReportedAndNotUsed) {
  const TempFolder folder;
  for (const auto& [unit, words] : std::vector<std::pair<std::uint16_t, std::string>>{
           {std::uint16_t{2}, "0.3527778 x 0.3527778 mm"}, {std::uint16_t{3}, "0.1388889"}}) {
    const auto source = described_tiff(folder, "", 72, unit);
    ASSERT_EQ(source->warnings().size(), 2U);
    EXPECT_TRUE(contains(source->warnings()[0], words)) << source->warnings()[0];
    EXPECT_TRUE(contains(source->warnings()[1], "[spacing_mm]"));
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{1, 1, 1}));
  }
}

TEST(TiffSource, ImageJCalibrationThatIsALineIsTheRescale) {
  const TempFolder folder;
  const std::string start = "ImageJ=1.53t\nimages=2\nunit=mm\nspacing=2\n";
  const auto signed_values =
      described_tiff(folder, start + "cf=0\nc0=-32768.0\nc1=1.0\nvunit=Gray Value\n", 1);
  EXPECT_EQ(signed_values->description().rescale, (Rescale{1, -32768}));
  EXPECT_FALSE(contains(signed_values->description().metadata.text(), "unit\":"));
  const auto hounsfield =
      described_tiff(folder, start + "cf=0\nc0=-1024\nc1=0.25\nvunit=HU\n", 1);
  EXPECT_EQ(hounsfield->description().rescale, (Rescale{0.25, -1024}));
  EXPECT_TRUE(contains(hounsfield->description().metadata.text(), "\"unit\":\"[hnsf'U]\""));
  const auto words =
      described_tiff(folder, start + "cf=0\nc0=-1024\nc1=0.25\nvunit=SECRET name\n", 1);
  EXPECT_FALSE(contains(words->description().metadata.text(), "unit\":"));
  EXPECT_FALSE(contains(words->description().metadata.text(), "SECRET"));
  const auto curve = described_tiff(folder, start + "cf=4\nc0=1\nc1=2\nc2=3\n", 1);
  EXPECT_EQ(curve->description().rescale, Rescale{});
  ASSERT_EQ(curve->warnings().size(), 1U);
  EXPECT_TRUE(contains(curve->warnings()[0], "function 4"));
}

TEST(TiffSource, OmeSpacingIsUsed) {
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

TEST(TiffSource, PagesCountWhereTheOmeDescriptionContradictsThem) {
  const TempFolder folder;
  const std::string path = folder.file("a.ome.tif");
  struct Case {
    std::uint16_t bits;
    std::uint16_t format;
    std::string pixels;
    std::string warning;  ///< none: empty
  };
  for (const Case& one : std::vector<Case>{
           {8, 1, R"(SizeX="4" SizeY="3" Type="uint8")", ""},
           {16, 2, R"(SizeX="4" SizeY="3" Type="int16")", ""},
           {32, 3, R"(SizeX="4" SizeY="3" Type="float")", ""},
           {64, 3, R"(SizeX="4" SizeY="3" Type="double")", ""},
           {8, 1, R"(SizeX="some" SizeY="")", ""},
           {8, 1, R"(SizeX="5" SizeY="3" Type="uint8")",
            "says 5 x 3 pixels of uint8, the pages have 4 x 3 of uint8, which counts"},
           {8, 1, R"(SizeY="4" Type="uint8")",
            "says 4 x 4 pixels of uint8, the pages have 4 x 3 of uint8, which counts"},
           {8, 1, R"(SizeX="4" SizeY="3" Type="uint16")",
            "says 4 x 3 pixels of uint16, the pages have 4 x 3 of uint8, which counts"},
           {16, 1, R"(SizeX="4" SizeY="3" Type="int16")",
            "says 4 x 3 pixels of int16, the pages have 4 x 3 of uint16, which counts"},
           {8, 1, R"(Type="bit")",
            "says 4 x 3 pixels of bit, the pages have 4 x 3 of uint8, which counts"}}) {
    TiffSample sample;
    sample.bits = one.bits;
    sample.format = one.format;
    sample.description = "<OME><Image><Pixels SizeZ=\"2\" SizeC=\"1\" SizeT=\"1\" " + one.pixels +
                         R"( PhysicalSizeX="1" PhysicalSizeY="1" PhysicalSizeZ="1"/>)" +
                         "</Image></OME>";
    const std::string zeros(12U * one.bits / 8, '\0');
    sample.pages = {zeros, zeros};
    write_tiff(path, sample);
    const auto source = open_source({path}, {});
    EXPECT_EQ(source->description().size, (Size3{4, 3, 2})) << one.pixels;
    if (one.warning.empty()) {
      EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
    } else {
      EXPECT_TRUE(contains(first_warning(*source), one.warning)) << first_warning(*source);
    }
  }
}

TEST(TiffSource, FilesThatAreNoVolumeAreRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0), counted(12, 1)};
  sample.description = "ImageJ=1.53t\nimages=2\nchannels=2\n";
  write_tiff(folder.file("channels.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("channels.tif")}), "2 channels"));
  sample.description = "ImageJ=1.53t\nimages=2\nframes=2\n";
  write_tiff(folder.file("frames.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("frames.tif")}), "points in time"));
  sample.description = "ImageJ=1.53t\nimages=9\nslices=9\n";
  write_tiff(folder.file("lost.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("lost.tif")}), "9 images, 2 pages"));
  sample = {};
  sample.samples = 3;
  sample.pages = {counted(36, 0)};
  write_tiff(folder.file("rgb.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("rgb.tif")}), "3 channels (red, green"));
}

TEST(TiffSource, AnOddPlaneIsNamedWithBothSizesOrTypes) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a1.tif"), sample);
  sample.width = 6;
  sample.pages = {counted(18, 0)};
  write_tiff(folder.file("a2.tif"), sample);
  Error error = source_error({folder.path()});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  EXPECT_TRUE(contains(error, "a2.tif is 6 x 3") && contains(error, "4 x 3"))
      << error.what();
  sample.width = 4;
  sample.bits = 16;
  sample.pages = {counted(24, 0)};
  write_tiff(folder.file("a2.tif"), sample);
  error = source_error({folder.path()});
  EXPECT_TRUE(contains(error, "uint16") && contains(error, "uint8")) << error.what();
}

/// A file whose description or tags tell of three planes, of which the first alone has a page.
TiffSample three_planes_on_a_page() {
  TiffSample sample;
  sample.pages = {std::string(12, '\x5a')};
  sample.rows_per_strip = 2;
  return sample;
}

/// The bytes of a.tif from its first voxel on, with room for three planes.
std::string grown_to_three_planes(const TempFolder& folder, const TiffSample& sample) {
  write_tiff(folder.file("a.tif"), sample);
  std::string bytes = read_file(folder.file("a.tif"));
  const std::size_t start = bytes.find(sample.pages[0]);
  if (bytes.size() < start + 36) bytes.resize(start + 36, '\x11');
  write_file(folder.file("a.tif"), bytes);
  return bytes.substr(start, 36);
}

TEST(TiffSource, AFileLargerThanItsTagsSayIsUnfoldedAsImageJWroteIt) {
  const TempFolder folder;
  TiffSample sample = three_planes_on_a_page();
  sample.description = "ImageJ=1.53t\nimages=3\nslices=3\n";
  const std::string voxels = grown_to_three_planes(folder, sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
}

TEST(TiffSource, PlanesThatTifffileTruncatedAreUnfolded) {
  const TempFolder folder;
  TiffSample sample = three_planes_on_a_page();
  sample.description = R"({"shape": [3, 3, 4], "truncated": true})";
  const std::string voxels = grown_to_three_planes(folder, sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
  write_file(folder.file("b.tif"), read_file(folder.file("a.tif")));
  EXPECT_TRUE(contains(source_error({folder.path()}), "has 3 planes"));
}

TEST(TiffSource, StripsWithMoreThanTheirRowsAreNotUnfolded) {
  const TempFolder folder;
  TiffSample sample = three_planes_on_a_page();
  sample.description = R"({"shape": [3, 3, 4], "truncated": true})";
  grown_to_three_planes(folder, sample);
  // The byte count of the last strip, of one row of 4 bytes, says 8: a row behind the page.
  std::string bytes = read_file(folder.file("a.tif"));
  const std::string counts("\x08\0\0\0\x04\0\0\0", 8);
  const std::string short_counts("\x08\0\x04\0", 4);
  const std::size_t at = std::min(bytes.find(counts), bytes.find(short_counts));
  ASSERT_NE(at, std::string::npos);
  bytes[at + (bytes.compare(at, 8, counts) == 0 ? 4 : 2)] = 8;
  write_file(folder.file("b.tif"), bytes);
  EXPECT_TRUE(contains(source_error({folder.file("b.tif")}), "3 images, 1 page"));
}

TEST(TiffSource, PlanesOfAMetaMorphStackAreUnfolded) {
  const TempFolder folder;
  TiffSample sample = three_planes_on_a_page();
  const float ones[3] = {1, 1, 1};
  sample.tags = {{33629, TIFF_RATIONAL, 3,
                  std::string(reinterpret_cast<const char*>(ones), sizeof ones)}};
  const std::string voxels = grown_to_three_planes(folder, sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
  sample.tags[0] = {33629, TIFF_RATIONAL, 1, sample.tags[0].values.substr(0, 4)};
  sample.pages = {counted(12, 0), counted(12, 1)};
  write_tiff(folder.file("pages.tif"), sample);
  EXPECT_EQ(open_source({folder.file("pages.tif")}, {})->description().size.z, 2);
}

TEST(TiffSource, AxesOfTifffileAreTimesAndChannels) {
  const TempFolder folder;
  TiffSample sample;
  for (int page = 0; page < 6; ++page) sample.pages.push_back(counted(12, page));
  const auto pages = [&](std::initializer_list<std::size_t> numbers) {
    std::string bytes;
    for (const std::size_t number : numbers) bytes += sample.pages[number];
    return bytes;
  };
  const auto write = [&](const std::string& description) {
    sample.description = description;
    write_tiff(folder.file("a.tif"), sample);
  };
  SourceOptions options;
  write(R"({"shape": [2, 3, 3, 4], "axes": "TZYX"})");
  EXPECT_TRUE(contains(source_error({folder.file("a.tif")}), "2 points in time"));
  options.time = 1;
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)), pages({3, 4, 5}));
  write(R"({"shape": [2, 3, 3, 4]})");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)), pages({3, 4, 5}));
  options = {};
  options.channel = "1";
  write(R"({"shape": [3, 2, 3, 4], "axes": "ZCYX"})");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)), pages({1, 3, 5}));
  write(R"({"shape": [6, 1, 3, 4], "axes": "IZYX"})");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), pages({0, 1, 2, 3, 4, 5}));
  write(R"({"axes": "ZCYX", "shape": [3, 2, 3, 4]})");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)), pages({1, 3, 5}));
  write(R"({"shape": [3, 4]})");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), pages({0, 1, 2, 3, 4, 5}));
  sample.descriptions = std::vector<std::string>(6);
  sample.descriptions[0] = R"({"shape": [4, 3, 4]})";
  write_tiff(folder.file("a.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("a.tif")}), "found are 6 pages"));
}

TEST(TiffSource, TheTextOfTifffileMayStandBehindThatOfTheUser) {
  const TempFolder folder;
  for (const bool big : {false, true}) {
    for (const bool big_endian : {false, true}) {
      TiffSample sample;
      sample.big = big;
      sample.big_endian = big_endian;
      sample.description = "hello";
      sample.further_description = R"({"shape": [2, 3, 3, 4], "axes": "TZYX"})";
      for (int page = 0; page < 6; ++page) sample.pages.push_back(counted(12, page));
      write_tiff(folder.file("a.tif"), sample);
      EXPECT_TRUE(contains(source_error({folder.file("a.tif")}), "2 points in time"));
      SourceOptions options;
      options.time = 1;
      EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, options)),
                sample.pages[3] + sample.pages[4] + sample.pages[5]);
    }
  }
  TiffSample sample = three_planes_on_a_page();
  sample.description = "hello";
  sample.further_description = R"({"shape": [3, 3, 4], "truncated": true})";
  const std::string voxels = grown_to_three_planes(folder, sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
}

TEST(TiffSource, OtherFormsOfTheTextOfTifffileAreRead) {
  const TempFolder folder;
  TiffSample sample = three_planes_on_a_page();
  for (const char* text : {"shape=(3, 3, 4)", "shape=(3, 1, 3, 4,)\n", "\n {\"shape\": [3, 3, 4]}",
                           R"({"axes": "zyx", "shape": [3, 3, 4]})",
                           R"({"axes": "ZYXS", "shape": [3, 3, 4, 1]})"}) {
    sample.description = text;
    const std::string voxels = grown_to_three_planes(folder, sample);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels) << text;
  }
  // What Python writes beside is not always JSON, and may be long and deep.
  std::string list = "1";
  for (int i = 0; i < 70000; ++i) list += ", 1";
  for (const std::string& value :
       {std::string("NaN"), std::string("-Infinity"), "[" + list + "]", std::string(30, '[') +
        std::string(30, ']'), '"' + std::string(70000, 'x') + '"', std::string(R"("a\"}, {")")}) {
    sample.description = R"({"shape": [3, 3, 4], "x": )" + value + R"(, "truncated": true})";
    const std::string voxels = grown_to_three_planes(folder, sample);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels) << value.substr(0, 40);
  }
  // Texts that are none
  for (const char* text : {"shape=(3, 3, 4", "shape=(3, -1, 4)", "shape=()", "shape=(3, x, 4)",
                           R"({"x": {"shape": [3, 3, 4]}})", R"({"x": "}, {\"shape\": [3, 3, 4]"})",
                           R"({"shape": [3, 3, 4], "x": ")", "{", "{}", R"({"shape"})"}) {
    sample.description = text;
    grown_to_three_planes(folder, sample);
    EXPECT_EQ(open_source({folder.file("a.tif")}, {})->description().size.z, 1) << text;
  }
}

TEST(TiffSource, PagesThatTifffileTurnedAreRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.pages = {counted(12, 0), counted(12, 1)};
  for (const std::string axes : {"XYZ", "YXZ", "XZY", "YZX", "ZXY", "QXY", "QZX"}) {
    sample.description = R"({"shape": [2, 3, 4], "axes": ")" + axes + "\"}";
    write_tiff(folder.file("a.tif"), sample);
    EXPECT_TRUE(contains(source_error({folder.file("a.tif")}), "\"" + axes + "\"")) << axes;
  }
  // An axis of one value turns nothing.
  sample.description = R"({"shape": [1, 2, 3, 4], "axes": "XZYX"})";
  write_tiff(folder.file("a.tif"), sample);
  EXPECT_EQ(open_source({folder.file("a.tif")}, {})->description().size, (Size3{4, 3, 2}));
}

TEST(TiffSource, PagesThatImageJDoesNotTellOfBringAWarning) {
  const TempFolder folder;
  for (const std::string program : {"ImageJ", "SCIFIO"}) {
    TiffSample sample;
    for (int page = 0; page < 5; ++page) sample.pages.push_back(counted(12, page));
    sample.description = program + "=1.53\nimages=4\nslices=4\nunit=mm\nspacing=1\n";
    sample.resolution = 1;
    sample.descriptions = {sample.description, "", "", "", ""};
    write_tiff(folder.file("a.tif"), sample);
    const auto source = open_source({folder.file("a.tif")}, {});
    EXPECT_EQ(source->description().size.z, 5);
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "says 4 images, 5 pages found"));
  }
  // Without a count of images those of slices tell of the planes behind a page.
  TiffSample sample = three_planes_on_a_page();
  sample.description = "ImageJ=1.53\nslices=3\n";
  const std::string voxels = grown_to_three_planes(folder, sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.tif")}, {})), voxels);
}

TEST(TiffSource, ZeissRecordsTellTimesAndSizes) {
  const TempFolder folder;
  TiffSample sample;
  for (int page = 0; page < 6; ++page) sample.pages.push_back(counted(12, page));
  const std::int32_t counts[10] = {0x0400494C, 64, 4, 3, 3, 1, 2, 1, 0, 0};
  const double meters[3] = {2e-6, 3e-6, 5e-6};
  std::string record(reinterpret_cast<const char*>(counts), sizeof counts);
  record.append(reinterpret_cast<const char*>(meters), sizeof meters);
  sample.tags = {{34412, TIFF_BYTE, 64, record}};
  write_tiff(folder.file("a.lsm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("a.lsm")}), "2 points in time"));
  SourceOptions options;
  options.time = 1;
  const auto source = open_source({folder.file("a.lsm")}, options);
  EXPECT_EQ(voxels_of(*source), sample.pages[3] + sample.pages[4] + sample.pages[5]);
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2e-3, 3e-3, 5e-3}));
}

TEST(TiffSource, PagesOfSeveralPlanesAreRejected) {
  const TempFolder folder;
  TiffSample sample;
  sample.depth = 2;
  sample.pages = {counted(12, 0)};
  write_tiff(folder.file("a.tif"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("a.tif")}), "ImageDepth"));
}

TEST(TiffSource, EveryTruncationIsRejected) {
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

}  // namespace
}  // namespace octavo::testing
