#include <gtest/gtest.h>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Pages of 4 x 3 voxels, the number of the page in each.
std::vector<std::string> numbered_pages(int count) {
  std::vector<std::string> pages;
  for (int page = 0; page < count; ++page) pages.emplace_back(12, static_cast<char>(page));
  return pages;
}

/// The first voxel of each plane, as a digit.
std::string pages_taken(PlaneSource& source) {
  const std::string voxels = voxels_of(source);
  std::string digits;
  for (std::size_t at = 0; at < voxels.size(); at += 12) {
    digits += static_cast<char>('0' + voxels[at]);
  }
  return digits;
}

class SourceTiff : public ::testing::Test {
 protected:
  /// Writes pages with a description; resolution 0 leaves the tags out.
  void write(const std::string& name, const std::string& description, int pages,
             float resolution = 0, float y_resolution = 0) {
    TiffSample sample;
    sample.description = description;
    sample.resolution = resolution;
    sample.y_resolution = y_resolution;
    sample.pages = numbered_pages(pages);
    write_tiff(folder_.file(name), sample);
  }
  std::unique_ptr<PlaneSource> open(const std::string& name, const SourceOptions& options = {}) {
    return open_source({name.empty() ? folder_.path() : folder_.file(name)}, options);
  }
  void expect_rejected(const std::string& name, const std::vector<std::string>& words,
                       const SourceOptions& options = {}) {
    const Error error =
        source_error({name.empty() ? folder_.path() : folder_.file(name)}, options);
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    for (const std::string& word : words) EXPECT_TRUE(contains(error, word)) << error.what();
  }

  TempFolder folder_;
};

TEST_F(SourceTiff, ImageJCountsMustMakeItsImages) {
  struct Case {
    std::string counts;
    std::string taken;  ///< of the last channel and time told; empty: rejected
  };
  // Of 12 pages: two channels, three slices, two times.
  for (const Case& one : std::vector<Case>{
           {"images=12\nchannels=2\nslices=3\nframes=2\n", "79;"},
           {"channels=2\nslices=3\nframes=2\n", "79;"},
           {"images=12\nchannels=2\nframes=2\n", "79;"},
           {"images=12\nslices=6\nframes=2\n", "6789:;"},
           {"images=12\nchannels=2\nslices=6\n", "13579;"},
           {"images=12\nslices=12\n", "0123456789:;"},
           {"images=12\n", "0123456789:;"},
           {"images=12\nchannels=3\nslices=3\nframes=2\n", ""},
           {"images=12\nchannels=1\nslices=3\nframes=2\n", ""},
           {"images=12\nchannels=2\nslices=2\nframes=2\n", ""},
           {"images=12\nchannels=2\nslices=6\nframes=2\n", ""},
           {"images=12\nchannels=2\nslices=3\nframes=3\n", ""},
           {"images=12\nchannels=2\nslices=3\nframes=1\n", ""},
           {"images=12\nslices=3\nframes=2\n", ""},
           {"images=12\nchannels=2\nslices=3\n", ""},
           {"images=12\nchannels=5\nframes=2\n", ""},
           {"images=12\nslices=3\n", ""},
           {"images=6\nchannels=2\nslices=3\n", ""},
           {"channels=2\nslices=3\n", ""}}) {
    TiffSample sample;
    sample.pages = numbered_pages(12);
    sample.descriptions.resize(12);
    sample.descriptions[0] = "ImageJ=1.53t\n" + one.counts;
    write_tiff(folder_.file("a.tif"), sample);
    SourceOptions options;
    options.channel = contains(one.counts, "channels=2") ? "1" : "";
    options.time = contains(one.counts, "frames=2") ? 1 : 0;
    if (one.taken.empty()) {
      expect_rejected("a.tif", {"its ImageJ description says", "12 pages"}, options);
    } else {
      EXPECT_EQ(pages_taken(*open("a.tif", options)), one.taken) << one.counts;
    }
  }
}

TEST_F(SourceTiff, ImageJUnitsOfTheAxesCount) {
  const std::string start = "ImageJ=1.53t\nimages=2\nslices=2\nspacing=2.5\nunit=micron\n";
  for (const auto& [units, spacing] : std::vector<std::pair<std::string, Point3>>{
           {"", {0.0005, 0.256, 0.0025}},
           {"yunit=mm\n", {0.0005, 256, 0.0025}},
           {"zunit=cm\n", {0.0005, 0.256, 25}},
           {"yunit=nm\nzunit=inch\n", {0.0005, 0.000256, 63.5}}}) {
    write("a.tif", start + units, 2, 2, 1.0F / 256);
    const auto source = open("a.tif");
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_DOUBLE_EQ(source->description().geometry.spacing_mm[axis], spacing[axis]) << units;
    }
    EXPECT_TRUE(source->warnings().empty());
  }
  for (const char* units : {"yunit=furlong\n", "zunit=furlong\n"}) {
    write("a.tif", start + units, 2, 2);
    const auto source = open("a.tif");
    ASSERT_EQ(source->warnings().size(), 2U);
    EXPECT_TRUE(contains(source->warnings()[0], "furlong"));
    EXPECT_TRUE(contains(source->warnings()[1], "[spacing_mm]"));
  }
  write("a.tif", start + "zunit=pixel\n", 2, 2);
  EXPECT_TRUE(contains(first_warning(*open("a.tif")), "no distance of planes"));
}

/// An OME description of `channels` x `slices` planes.
std::string ome(const std::string& tiff_data, int slices, int channels = 1,
                const std::string& order = "XYZCT", const std::string& id = "",
                const std::string& size = "") {
  return "<?xml version=\"1.0\"?><OME" + id + "><Image><Pixels DimensionOrder=\"" + order +
         "\" SizeZ='" + std::to_string(slices) + "'\n SizeC=\"" + std::to_string(channels) +
         "\" SizeT=\"1\" " + size + ">" + tiff_data + "</Pixels></Image></OME>";
}

TEST_F(SourceTiff, OmeUnitsMayBeEscaped) {
  for (const auto& [unit, mm] : std::vector<std::pair<std::string, double>>{
           {"&#181;m", 1e-3}, {"&#xB5;m", 1e-3}, {"&#x3bc;m", 1e-3}, {"\xc2\xb5m", 1e-3},
           {"&#109;m", 1}}) {
    std::string size;
    for (const std::string axis : {"X", "Y", "Z"}) {
      size += "PhysicalSize" + axis + "=\"2\" PhysicalSize" + axis + "Unit=\"" + unit + "\" ";
    }
    write("a.ome.tif", ome("", 2, 1, "XYZCT", "", size), 2);
    EXPECT_EQ(open("a.ome.tif")->description().geometry.spacing_mm,
              (Point3{2 * mm, 2 * mm, 2 * mm})) << unit;
  }
}

TEST_F(SourceTiff, OmeUnitsThatAreNotKnownAreLeftOutWithAWarning) {
  for (const auto& [unit, shown] : std::vector<std::pair<std::string, std::string>>{
           {"&lt;&#;", "<&#;"}, {"Mm", "Mm"}, {"Pm", "Pm"}}) {
    write("a.ome.tif", ome("", 2, 1, "XYZCT", "", "PhysicalSizeX=\"2\" PhysicalSizeXUnit=\"" +
                                                      unit + "\""), 2);
    const std::string warning = first_warning(*open("a.ome.tif"));
    EXPECT_TRUE(contains(warning, "OME description counts lengths in \"" + shown)) << warning;
  }
}

TEST_F(SourceTiff, OmeTiffDataGiveTheOrderOfPages) {
  const std::string uuid = "<UUID FileName=\"old.ome.tif\">urn:uuid:1</UUID></TiffData>";
  for (const auto& [data, taken] : std::vector<std::pair<std::string, std::string>>{
           {"", "0123"},
           {"<TiffData/>", "0123"},
           {"<TiffData IFD=\"0\" PlaneCount=\"4\"/>", "0123"},
           {"<TiffData PlaneCount=\"4\"></TiffData>", "0123"},
           {"<TiffData FirstZ=\"3\" IFD=\"0\" PlaneCount=\"1\"/><TiffData FirstZ=\"2\" IFD=\"1\"/>"
            "<TiffData IFD=\"2\" FirstZ=\"1\"/><TiffData IFD=\"3\"/>", "3210"},
           {"<TiffData IFD=\"2\" PlaneCount=\"2\"/><TiffData FirstZ=\"2\" PlaneCount=\"2\"/>",
            "2301"},
           {"<TiffData PlaneCount=\"2\">" + uuid + "<TiffData IFD=\"2\" FirstZ=\"2\" "
            "PlaneCount=\"2\">" + uuid, "0123"}}) {
    write("a.ome.tif", ome(data, 4), 4);
    EXPECT_EQ(pages_taken(*open("a.ome.tif")), taken) << data;
  }
}

TEST_F(SourceTiff, OmeTiffDataGiveTheOrderOfChannels) {
  SourceOptions second;
  second.channel = "1";
  const std::string data = "<TiffData IFD=\"0\" FirstC=\"1\" PlaneCount=\"2\"/>"
                           "<TiffData IFD=\"2\" FirstC=\"0\" PlaneCount=\"2\"/>";
  write("a.ome.tif", ome(data, 2, 2), 4);
  EXPECT_EQ(pages_taken(*open("a.ome.tif", second)), "01");
  const std::string alternating = "<TiffData IFD=\"0\" FirstZ=\"1\" PlaneCount=\"2\"/>"
                                  "<TiffData IFD=\"2\" FirstZ=\"0\" PlaneCount=\"2\"/>";
  write("a.ome.tif", ome(alternating, 2, 2, "XYCZT"), 4);
  EXPECT_EQ(pages_taken(*open("a.ome.tif", second)), "31");
}

TEST_F(SourceTiff, OmeTiffDataThatLeaveAPlaneOpenAreRejected) {
  for (const auto& [data, words] : std::vector<std::pair<std::string, std::string>>{
           {"<TiffData IFD=\"0\" PlaneCount=\"3\"/>", "3 pages to 4 planes"},
           {"<TiffData IFD=\"0\" PlaneCount=\"5\"/>", "5 pages"},
           {"<TiffData/><TiffData IFD=\"1\"/>", "page 0 and page 1 to one plane"},
           {"<TiffData IFD=\"1\" PlaneCount=\"4\"/>", "page 4"},
           {"<TiffData/><TiffData/>", "to one plane"},
           {"<TiffData FirstZ=\"4\"/>", "slice 4"},
           {"<TiffData FirstZ=\"x\"/>", "slice -1"},
           {"<TiffData IFD=\"9223372036854775807\" PlaneCount=\"4\"/>", "pages from page"},
           {"<TiffData PlaneCount=\"2\"/><TiffData FirstZ=\"2\" PlaneCount=\"2\"/>",
            "2 pages to 4 planes"}}) {
    write("a.ome.tif", ome(data, 4), 4);
    expect_rejected("a.ome.tif", {words, "OME"});
  }
}

TEST_F(SourceTiff, OmePlanesOfOtherFilesAreRejected) {
  const auto part = [](int page, int slice, const std::string& name, const std::string& id) {
    return "<TiffData IFD=\"" + std::to_string(page) + "\" FirstZ=\"" + std::to_string(slice) +
           "\"><UUID FileName=\"" + name + "\">" + id + "</UUID></TiffData>";
  };
  write("a.ome.tif", ome(part(0, 0, "a.ome.tif", "1") + part(0, 1, "b.ome.tif", "2"), 2), 2);
  expect_rejected("a.ome.tif", {"b.ome.tif", "slice 1", "bfconvert"});
  write("a.ome.tif", ome(part(0, 0, "b.ome.tif", "2") + part(1, 1, "b.ome.tif", "2"), 2, 1,
                         "XYZCT", " UUID=\"1\""), 2);
  expect_rejected("a.ome.tif", {"b.ome.tif"});
  write("a.ome.tif", ome(part(0, 0, "b.ome.tif", "1") + part(1, 1, "c.ome.tif", "1"), 2, 1,
                         "XYZCT", " UUID=\"1\""), 2);
  EXPECT_EQ(pages_taken(*open("a.ome.tif")), "01");
  write("a.ome.tif", "<OME><BinaryOnly MetadataFile=\"all.companion.ome\" UUID=\"1\"/></OME>", 2);
  expect_rejected("a.ome.tif", {"all.companion.ome"});
}

TEST_F(SourceTiff, OmeFilesMustLieInTheOrderOfTheirSlices) {
  const auto names = [](const std::string& first, const std::string& second) {
    return ome("<TiffData FirstZ=\"0\"><UUID FileName=\"" + first + "\"/></TiffData>"
               "<TiffData FirstZ=\"1\"><UUID FileName=\"" + second + "\"/></TiffData>", 2);
  };
  write("z1.tif", names("z1.tif", "z2.tif"), 1);
  write("z2.tif", "", 1);
  EXPECT_EQ(open("")->description().size.z, 2);
  write("z1.tif", names("z2.tif", "z1.tif"), 1);
  expect_rejected("", {"z1.tif", "makes it slice 1", "slice 0"});
  write("z1.tif", names("z1.tif", "z3.tif"), 1);
  expect_rejected("", {"z2.tif", "does not name it"});
  write("z1.tif", names("a.tif", "b.tif"), 1);
  EXPECT_TRUE(contains(first_warning(*open("")), "names other files"));
}

TEST_F(SourceTiff, PagesWithAPaletteOrTurnedAreRejectedBesideOthers) {
  TiffSample sample;
  sample.pages = numbered_pages(3);
  sample.palettes = {false, false, true};
  write_tiff(folder_.file("a.tif"), sample);
  expect_rejected("a.tif", {"page 2", "palette"});
  sample.palettes = {};
  sample.orientations = {1, 1, 2};
  write_tiff(folder_.file("a.tif"), sample);
  expect_rejected("a.tif", {"page 2", "orientation tag 2", "page 0 has 1"});
  sample.orientations = {2, 2, 2};
  write_tiff(folder_.file("a.tif"), sample);
  EXPECT_TRUE(contains(first_warning(*open("a.tif")), "orientation tag 2"));
}

TEST_F(SourceTiff, FilesOfDifferentMeaningAreNamedWithBoth) {
  const std::string start = "ImageJ=1.53t\nunit=mm\nspacing=2\n";
  const std::string line = "cf=0\nc0=0\nc1=1\nvunit=HU\n";
  write("s0.tif", start + line, 1, 4);
  SourceOptions spacing;
  spacing.spacing_mm = Point3{1, 1, 1};
  for (const auto& [text, words] : std::vector<std::pair<std::string, std::string>>{
           {"cf=0\nc0=-1000\nc1=2\nvunit=HU\n", "2 x + -1000 HU"},
           {"cf=0\nc0=0\nc1=1\nvunit=OD\n", "1 x + 0 OD"},
           {"cf=4\nc0=0\nc1=1\n", "function 4"}}) {
    write("s1.tif", start + text, 1, 4);
    expect_rejected("", {"s1.tif has the calibration " + words, "s0.tif has 1 x + 0 HU"});
    expect_rejected("", {words}, spacing);
  }
  write("s1.tif", start + line, 1, 5);
  expect_rejected("", {"s1.tif", "0.2 mm", "s0.tif", "0.25 mm", "[spacing_mm]"});
  EXPECT_EQ(open("", spacing)->description().size.z, 2);
  write("s1.tif", start + line, 1, 4.001F);
  EXPECT_TRUE(open("")->warnings().empty());
  write("s1.tif", "ImageJ=1.53t\nunit=furlong\n" + line, 1, 4);
  expect_rejected("", {"furlong", "[spacing_mm]"});
  write("s1.tif", "ImageJ=1.53t\n" + line, 1, 4);
  EXPECT_TRUE(contains(first_warning(*open("")), "1 of the others does not"));
}

TEST_F(SourceTiff, ResolutionTagsThatDifferAreReported) {
  for (const char* name : {"s0.tif", "s1.tif"}) {
    TiffSample sample;
    sample.pages = numbered_pages(1);
    sample.resolution = name == std::string("s0.tif") ? 72 : 96;
    sample.resolution_unit = 2;
    write_tiff(folder_.file(name), sample);
  }
  EXPECT_TRUE(contains(first_warning(*open("")), "those of s1.tif differ"));
}

}  // namespace
}  // namespace octavo::testing
