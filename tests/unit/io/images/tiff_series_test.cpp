#include "octavo/io/images/tiff_series.h"

#include <gtest/gtest.h>

#include <tiffio.h>

#include <ctime>
#include <filesystem>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

SourceOptions with_series(const std::string& series) {
  SourceOptions options;
  options.series = series;
  return options;
}

std::string voxels_in(const std::string& path, const std::string& series) {
  return voxels_of(*open_source({path}, with_series(series)));
}

/// Appends pages of 8 bits to the file.
/// description  of the first of them
void append_pages(const std::string& path, std::uint32_t width, std::uint32_t height,
                  const std::vector<std::string>& pages, const std::string& description,
                  bool is_reduced = false) {
  TIFF* tiff = TIFFOpen(path.c_str(), "a");
  ASSERT_NE(tiff, nullptr);
  for (std::size_t i = 0; i < pages.size(); ++i) {
    std::string page = pages[i];
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, width);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, height);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, height);
    if (is_reduced) TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, FILETYPE_REDUCEDIMAGE);
    if (i == 0 && !description.empty()) {
      TIFFSetField(tiff, TIFFTAG_IMAGEDESCRIPTION, description.c_str());
    }
    const auto bytes = static_cast<tmsize_t>(page.size());
    ASSERT_EQ(TIFFWriteEncodedStrip(tiff, 0, page.data(), bytes), bytes);
    ASSERT_EQ(TIFFWriteDirectory(tiff), 1);
  }
  TIFFClose(tiff);
}

TEST(TiffSeries, SeveralInOneFileAreListed) {
  const TempFolder folder;
  TiffSample sample;
  for (int page = 0; page < 5; ++page) sample.pages.push_back(counted(12, page));
  const std::string one = R"({"shape": [3, 4]})";
  const std::string four = R"({"shape": [2, 2, 3, 4], "axes": "CZYX"})";
  const std::string cut = R"({"shape": [6, 3, 4], "truncated": true})";
  const auto listed = [&](const std::vector<std::string>& texts) {
    sample.descriptions = texts;
    write_tiff(folder.file("a.tif"), sample);
    return source_error({folder.file("a.tif")});
  };
  EXPECT_TRUE(contains(listed({one, four, "", "", ""}),
                       "2 series of pages (0: 1 plane of 4 x 3 in page 0; 1: 4 planes of 4 x 3 "
                       "in pages 1 to 4)"));
  EXPECT_TRUE(contains(listed({"", four, "", "", ""}), "2 series"));
  EXPECT_TRUE(contains(listed({"", "", "", one, cut}),
                       "(0: 4 planes of 4 x 3 in pages 0 to 3; 1: 6 planes of 4 x 3 from page 4 "
                       "on)"));
  EXPECT_TRUE(contains(listed({cut, one, one, one, one}), "1: 4 planes of 4 x 3 in pages 1 to 4"));
  EXPECT_TRUE(contains(listed({cut, cut, cut, cut, cut}), "[series=0 to 4]"));
  EXPECT_TRUE(contains(listed({"ImageJ=1\nimages=2\n", "", "ImageJ=1\nimages=3\n", "", ""}),
                       "2 series"));
  // Pages saved one by one are one stack.
  for (const std::vector<std::string>& texts :
       {std::vector<std::string>(5, one), {"ImageJ=1\n", one, "a", "", "ImageJ=1\n"},
        std::vector<std::string>(5, "ImageJ=1\nimages=5\n")}) {
    sample.descriptions = texts;
    write_tiff(folder.file("a.tif"), sample);
    EXPECT_EQ(open_source({folder.file("a.tif")}, {})->description().size.z, 5);
  }
}

TEST(TiffSeries, IsTakenByItsNumber) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  const std::string two = counted(12, 1) + counted(12, 2);
  const std::string three = counted(20, 3) + counted(20, 4) + counted(20, 5);
  append_pages(path, 4, 3, {two.substr(0, 12), two.substr(12)}, R"({"shape": [2, 3, 4]})");
  append_pages(path, 5, 4, {three.substr(0, 20), three.substr(20, 20), three.substr(40)},
               "ImageJ=1.53\nimages=3\nslices=3\nunit=mm\nspacing=2\n");
  EXPECT_TRUE(contains(source_error({path}), "0: 2 planes of 4 x 3 in pages 0 to 1; 1: 3 planes of "
                                             "5 x 4 in pages 2 to 4), and a volume is made of one "
                                             "[series=0 or 1]"));
  EXPECT_EQ(voxels_in(path, "0"), two);
  EXPECT_EQ(voxels_in(path, "1"), three);
  for (const char* series : {"2", "-1", "1x", "1.2.840"}) {
    const Error error = source_error({path}, with_series(series));
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_TRUE(contains(error, std::string("series ") + series + " is not there")) << error.what();
  }
}

TEST(TiffSeries, OfATruncatedArrayStandsBehindItsPage) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  append_pages(path, 4, 3, {counted(12, 1), counted(12, 2)}, R"({"shape": [2, 3, 4]})");
  append_pages(path, 4, 3, {counted(12, 7)}, R"({"shape": [3, 3, 4], "truncated": true})");
  const std::string bytes = read_file(path);
  const std::size_t start = bytes.find(counted(12, 7));
  ASSERT_NE(start, std::string::npos);
  EXPECT_EQ(voxels_in(path, "1"), bytes.substr(start, 36));
}

TEST(TiffSeries, OfPagesThatNothingTellsOfAreThoseAlike) {
  const TempFolder folder;
  const std::string path = folder.file("a.tif");
  append_pages(path, 4, 3, {counted(12, 1), counted(12, 2)}, "");
  append_pages(path, 5, 4, {counted(20, 3)}, "");
  EXPECT_TRUE(contains(source_error({path}), "page 2 is 5 x 4, page 0 is 4 x 3; all planes of a "
                                             "stack must have one size [series=0 or 1]"));
  EXPECT_EQ(voxels_in(path, "0"), counted(12, 1) + counted(12, 2));
  EXPECT_EQ(voxels_in(path, "1"), counted(20, 3));
}

TEST(TiffSeries, OfSmallerPicturesAreLeftOutBesideAVolume) {
  const TempFolder folder;
  const std::string volume = counted(20, 3) + counted(20, 4);
  const std::vector<std::string> planes = {volume.substr(0, 20), volume.substr(20)};
  const std::string text = R"({"shape": [2, 4, 5]})";
  append_pages(folder.file("first.tif"), 2, 2, {counted(4, 0)}, R"({"shape": [2, 2]})");
  append_pages(folder.file("first.tif"), 5, 4, planes, text);
  append_pages(folder.file("last.tif"), 5, 4, planes, text);
  append_pages(folder.file("last.tif"), 2, 2, {counted(4, 0)}, R"({"shape": [2, 2]})");
  for (const char* name : {"first.tif", "last.tif"}) {
    const auto source = open_source({folder.file(name)}, with_spacing(1, 1, 1));
    EXPECT_EQ(voxels_of(*source), volume);
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "1 smaller picture beside the volume left out (1 "
                                                "plane of 2 x 2 in page "));
  }
  EXPECT_EQ(voxels_in(folder.file("last.tif"), "1"), counted(4, 0));
  // One of the same size may be of the volume.
  append_pages(folder.file("same.tif"), 5, 4, {counted(20, 9)}, R"({"shape": [4, 5]})");
  append_pages(folder.file("same.tif"), 5, 4, planes, text);
  EXPECT_TRUE(contains(source_error({folder.file("same.tif")}), "2 series"));
}

TEST(TiffSeries, HaveNoThumbnailsInFrontOfThem) {
  const TempFolder folder;
  const std::string volume = counted(20, 3) + counted(20, 4);
  for (const int count : {1, 2}) {
    const std::string path = folder.file(std::to_string(count) + ".tif");
    const std::vector<std::string> small(static_cast<std::size_t>(count), counted(4, 0));
    append_pages(path, 2, 2, small, "", true);
    append_pages(path, 5, 4, {volume.substr(0, 20), volume.substr(20)}, R"({"shape": [2, 4, 5]})");
    append_pages(path, 2, 2, small, "", true);
    const auto source = open_source({path}, {});
    EXPECT_EQ(voxels_of(*source), volume);
    EXPECT_TRUE(contains(with_hints(source->warnings()),
                         std::to_string(2 * count) + " thumbnail pages left out"));
  }
  append_pages(folder.file("s/1.tif"), 2, 2, {counted(4, 0)}, "", true);
  append_pages(folder.file("s/1.tif"), 5, 4, {counted(20, 3)}, "");
  append_pages(folder.file("s/2.tif"), 5, 4, {counted(20, 4)}, "");
  append_pages(folder.file("s/2.tif"), 2, 2, {counted(4, 0)}, "", true);
  EXPECT_EQ(voxels_of(*open_source({folder.file("s")}, {})), volume);
  append_pages(folder.file("alone.tif"), 2, 2, {counted(4, 0)}, "", true);
  EXPECT_EQ(voxels_of(*open_source({folder.file("alone.tif")}, {})), counted(4, 0));
}

/// A pair name="value" of XML.
std::string pair(const std::string& name, const std::string& value) {
  return " " + name + "=\"" + value + "\"";
}

/// An image of OME with `planes` slices whose pages begin at `page`.
std::string image_of_ome(const std::string& name, int planes, int page, int width, int height) {
  return "<Image" + pair("Name", name) + "><Pixels" + pair("DimensionOrder", "XYZCT") +
         pair("SizeX", std::to_string(width)) + pair("SizeY", std::to_string(height)) +
         pair("SizeZ", std::to_string(planes)) + pair("SizeC", "1") + pair("SizeT", "1") +
         pair("PhysicalSizeX", std::to_string(page + 1)) + pair("PhysicalSizeY", "2") +
         pair("PhysicalSizeZ", "3") + "><TiffData" + pair("IFD", std::to_string(page)) +
         pair("PlaneCount", std::to_string(planes)) + "/></Pixels></Image>";
}

TEST(TiffSeries, AreTheImagesOfOme) {
  const TempFolder folder;
  const std::string two = counted(12, 1) + counted(12, 2);
  const std::string three = counted(20, 3) + counted(20, 4) + counted(20, 5);
  const auto written = [&](const std::string& name, const std::string& images) {
    const std::string path = folder.file(name + ".ome.tif");
    append_pages(path, 4, 3, {two.substr(0, 12), two.substr(12)}, "<OME>" + images + "</OME>");
    append_pages(path, 5, 4, {three.substr(0, 20), three.substr(20, 20), three.substr(40)}, "");
    return path;
  };
  const std::string path =
      written("a", image_of_ome("left &lt;", 2, 0, 4, 3) + image_of_ome("right", 3, 2, 5, 4));
  EXPECT_TRUE(contains(source_error({path}), "2 series of pages (0: \"left <\", 2 planes of 4 x 3; "
                                             "1: \"right\", 3 planes of 5 x 4), and a volume is "
                                             "made of one [series=0 or 1]"));
  EXPECT_EQ(voxels_in(path, "0"), two);
  EXPECT_EQ(voxels_in(path, "1"), three);
  const double last_x_mm = geometry_of(path, with_series("1")).spacing_mm[0];
  EXPECT_DOUBLE_EQ(geometry_of(path, with_series("0")).spacing_mm[0], 0.001);
  EXPECT_DOUBLE_EQ(last_x_mm, 0.003);
  EXPECT_EQ(source_error({path}, with_series("2")).kind(), ErrorKind::invalid_argument);

  // Nothing says which pages are whose.
  EXPECT_TRUE(contains(source_error({written("b", "<Image><Pixels SizeZ=\"2\"/></Image><Image>"
                                                  "<Pixels SizeZ=\"3\"/></Image>")},
                                    with_series("1")),
                       "does not say which pages are those of number 1"));
}

TEST(TiffSeries, OfOmeIsTheVolumeBesideAPictureOfItsLabel) {
  const TempFolder folder;
  const std::string path = folder.file("a.ome.tif");
  const std::string volume = counted(20, 3) + counted(20, 4);
  append_pages(path, 4, 3, {counted(12, 8)},
               "<OME>" + image_of_ome("label", 1, 0, 4, 3) + image_of_ome("scan", 2, 1, 5, 4) +
                   "</OME>");
  append_pages(path, 5, 4, {volume.substr(0, 20), volume.substr(20)}, "");
  const auto source = open_source({path}, {});
  EXPECT_EQ(voxels_of(*source), volume);
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "left out (\"label\", 1 plane of 4 x 3)"));
  EXPECT_EQ(voxels_in(path, "0"), counted(12, 8));
}

TEST(TiffSeries, OfOmeIsTheVolumeBesideAPictureInColors) {
  const TempFolder folder;
  const std::string path = folder.file("a.ome.tif");
  const std::string volume = counted(20, 3) + counted(20, 4);
  const auto picture = [](const std::string& channels) {
    return "<Image" + pair("Name", "label") + "><Pixels" + pair("SizeX", "4") +
           pair("SizeY", "3") + pair("SizeZ", "1") + pair("SizeC", "3") + pair("SizeT", "1") +
           pair("DimensionOrder", "XYCZT") + ">" + channels + "<TiffData" + pair("IFD", "0") +
           pair("PlaneCount", "1") + "/></Pixels></Image>";
  };
  TiffSample label;
  label.samples = 3;
  label.pages = {counted(36, 8)};
  const auto write = [&](const std::string& channels) {
    label.description = "<OME>" + picture(channels) + image_of_ome("scan", 2, 1, 5, 4) + "</OME>";
    write_tiff(path, label);
    append_pages(path, 5, 4, {volume.substr(0, 20), volume.substr(20)}, "");
  };
  write("<Channel" + pair("SamplesPerPixel", "3") + "/>");
  const auto source = open_source({path}, {});
  EXPECT_EQ(voxels_of(*source), volume);
  ASSERT_EQ(source->warnings().size(), 1U);
  EXPECT_TRUE(contains(source->warnings()[0], "left out (\"label\", 1 plane of 4 x 3)"));
  // Samples that stand in no whole number of pages are planes each.
  for (const char* samples : {"0", "2", "-3", "x"}) {
    write("<Channel" + pair("SamplesPerPixel", samples) + "/>");
    EXPECT_TRUE(contains(source_error({path}), "0: \"label\", 3 planes of 4 x 3")) << samples;
  }
}

TEST(TiffSeries, OfOmeMayClaimAnyPages) {
  const TempFolder folder;
  const std::string path = folder.file("a.ome.tif");
  const auto claims = [](const std::string& attributes, int count) {
    std::string image = "<Image><Pixels SizeX=\"4\" SizeY=\"3\" SizeZ=\"2\">";
    for (int i = 0; i < count; ++i) image += "<TiffData" + attributes + "/>";
    return image + "</Pixels></Image>";
  };
  const auto error_of_first = [&](const std::string& image, std::size_t pages) {
    std::filesystem::remove(path);
    append_pages(path, 4, 3, std::vector<std::string>(pages, counted(12, 1)),
                 "<OME>" + image + image_of_ome("scan", 2, 1, 4, 3) + "</OME>");
    return source_error({path}, with_series("0"));
  };
  const std::string last = pair("IFD", "9223372036854775807");
  const std::string many = pair("PlaneCount", "9223372036854775807");
  for (const std::string& attributes : {last, last + many, last + pair("PlaneCount", "2")}) {
    EXPECT_TRUE(contains(error_of_first(claims(attributes, 1), 3), "no page of this file"));
  }
  EXPECT_TRUE(contains(error_of_first(claims(pair("IFD", "1") + many, 1), 3), "from page 1 on"));
  // Each of many tells of all pages.
  const std::clock_t began = std::clock();
  EXPECT_TRUE(contains(error_of_first(claims("", 100'000), 1000), "found are 1000 pages"));
  const double seconds = static_cast<double>(std::clock() - began) / CLOCKS_PER_SEC;
  EXPECT_LT(seconds, 2);
}

}  // namespace
}  // namespace octavo::testing
