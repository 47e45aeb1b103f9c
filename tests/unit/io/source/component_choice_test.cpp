// Sources with several values at a voxel or several volumes in time: one is taken by option only.
#include <gtest/gtest.h>
#include <tiff.h>

#include "support/dicom_samples.h"
#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::size_t kVoxels = 24;  // 4 x 3 x 2

/// Voxels of a channel and a time: no two volumes share a value.
std::string volume(int channel, int time = 0) {
  std::string bytes;
  for (std::size_t i = 0; i < kVoxels; ++i) {
    bytes += static_cast<char>(static_cast<int>(i) + 25 * (channel + 4 * time));
  }
  return bytes;
}

/// Channels that alternate.
std::string alternating(int channels, int time = 0) {
  std::string bytes;
  for (std::size_t i = 0; i < kVoxels; ++i) {
    for (int channel = 0; channel < channels; ++channel) bytes += volume(channel, time)[i];
  }
  return bytes;
}

SourceOptions choose(const std::string& channel, std::optional<std::int64_t> time = {}) {
  SourceOptions options;
  options.channel = channel;
  options.time = time;
  options.spacing_mm = Point3{1, 1, 1};
  return options;
}

/// Every choice gives its own voxels, none and wrong ones are rejected.
void expect_components(const std::string& path, int channels, int times,
                       const std::vector<std::string>& names = {}) {
  SCOPED_TRACE(path);
  SourceOptions spacing = choose("");
  const Error none = source_error({path}, spacing);
  EXPECT_EQ(none.kind(), ErrorKind::source_rejected) << none.what();
  EXPECT_EQ(none.path(), path);
  EXPECT_EQ(contains(none, std::to_string(channels) + " channels"), channels > 1)
      << none.what();
  EXPECT_EQ(contains(none, std::to_string(times) + " points in time"), times > 1)
      << none.what();
  EXPECT_EQ(contains(none, "[channel="), channels > 1) << none.what();
  EXPECT_EQ(contains(none, "[time="), times > 1) << none.what();
  for (int time = 0; time < times; ++time) {
    for (int channel = 0; channel < channels; ++channel) {
      const std::string number = channels > 1 ? std::to_string(channel) : "";
      const std::optional<std::int64_t> when =
          times > 1 ? std::optional<std::int64_t>(time) : std::nullopt;
      const auto source = open_source({path}, choose(number, when));
      EXPECT_EQ(source->description().size, (Size3{4, 3, 2}));
      EXPECT_EQ(voxels_of(*source), volume(channel, time)) << channel << " " << time;
      for (const Warning& warning : source->warnings()) {
        EXPECT_FALSE(contains(warning, "behind")) << warning;
      }
      const std::string& metadata = source->description().metadata.text();
      EXPECT_TRUE(contains(metadata, "\"chosen\":{")) << metadata;
      if (names.empty()) continue;
      const auto& name = names[static_cast<std::size_t>(channel)];
      EXPECT_TRUE(contains(metadata, "\"name\":\"" + name + "\"")) << metadata;
      EXPECT_EQ(voxels_of(*open_source({path}, choose(name, when))), volume(channel, time));
    }
  }
  std::optional<std::int64_t> first;
  if (times > 1) first = 0;
  for (const char* wrong : {"9", "-1", "purple", "1x"}) {
    EXPECT_EQ(source_error({path}, choose(wrong, first)).kind(), ErrorKind::invalid_argument);
  }
  for (const std::int64_t wrong : {std::int64_t{9}, std::int64_t{-1}}) {
    const Error error = source_error({path}, choose(channels > 1 ? "0" : "", wrong));
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument) << error.what();
  }
}

void write_nifti(const std::string& path, const std::vector<std::int16_t>& size,
                 std::int16_t datatype, const std::string& voxels) {
  NiftiSample sample;
  sample.size = size;
  sample.datatype = datatype;
  const std::string bytes = nifti_header(sample) + voxels;
  write_file(path, path.ends_with("gz") ? gzip(bytes) : bytes);
}

TEST(SourceComponents, OfColorAreNoLabelsWhateverTheHeaderMeansThemFor) {
  const TempFolder folder;
  NiftiSample sample;
  sample.size = {4, 3, 2};
  sample.datatype = 2304;
  std::string bytes = nifti_header(sample) + alternating(4);
  bytes.replace(68, 2, bytes_of<std::int16_t>({1002}));  // intent: label
  write_file(folder.file("rgba.nii"), bytes);
  SourceOptions options;
  options.channel = "alpha";
  EXPECT_EQ(open_source({folder.file("rgba.nii")}, options)->description().kind, VolumeKind::grey);
  sample.datatype = 2;
  bytes = nifti_header(sample) + volume(0);
  bytes.replace(68, 2, bytes_of<std::int16_t>({1002}));
  write_file(folder.file("labels.nii"), bytes);
  EXPECT_EQ(open_source({folder.file("labels.nii")}, {})->description().kind, VolumeKind::labels);
}

TEST(SourceComponents, OfNiftiAreColorsTimesAndValues) {
  const TempFolder folder;
  for (const std::string& ending : {std::string(".nii"), std::string(".nii.gz")}) {
    write_nifti(folder.file("rgb" + ending), {4, 3, 2}, 128, alternating(3));
    expect_components(folder.file("rgb" + ending), 3, 1, {"red", "green", "blue"});
    write_nifti(folder.file("rgba" + ending), {4, 3, 2, 2}, 2304,
                alternating(4) + alternating(4, 1));
    expect_components(folder.file("rgba" + ending), 4, 2, {"red", "green", "blue", "alpha"});
    write_nifti(folder.file("time" + ending), {4, 3, 2, 2}, 2, volume(0, 0) + volume(0, 1));
    expect_components(folder.file("time" + ending), 1, 2);
    write_nifti(folder.file("vector" + ending), {4, 3, 2, 1, 3}, 2,
                volume(0) + volume(1) + volume(2));
    expect_components(folder.file("vector" + ending), 3, 1);
    write_nifti(folder.file("both" + ending), {4, 3, 2, 2, 2}, 2,
                volume(0, 0) + volume(0, 1) + volume(1, 0) + volume(1, 1));
    expect_components(folder.file("both" + ending), 2, 2);
  }
}

TEST(SourceComponents, OfNiftiAreCountedInItsLength) {
  const TempFolder folder;
  for (const std::string& ending : {std::string(".nii"), std::string(".nii.gz")}) {
    const std::string path = folder.file("cut" + ending);
    write_nifti(path, {4, 3, 2, 2}, 2, volume(0, 0) + volume(0, 1).substr(0, kVoxels - 1));
    for (const std::int64_t time : {0, 1}) {
      EXPECT_EQ(source_error({path}, choose("", time)).kind(), ErrorKind::source_rejected) << path;
    }
  }
}

std::string nrrd(const std::string& sizes, const std::string& kinds, const std::string& directions,
                 const std::string& voxels, bool is_deflated = false) {
  const auto count = 1 + std::count(sizes.begin(), sizes.end(), ' ');
  return "NRRD0005\ntype: uchar\ndimension: " + std::to_string(count) + "\nsizes: " + sizes +
         (kinds.empty() ? "" : "\nkinds: " + kinds) +
         (directions.empty() ? "" : "\nspace: LPS\nspace directions: " + directions) +
         "\nencoding: " + (is_deflated ? "gzip" : "raw") + "\n\n" +
         (is_deflated ? gzip(voxels) : voxels);
}

TEST(SourceComponents, OfNrrdStandBeforeOrBehindSpace) {
  const TempFolder folder;
  const std::string space = "(1,0,0) (0,1,0) (0,0,1)";
  const std::string path = folder.file("a.nrrd");
  for (const bool is_deflated : {false, true}) {
    write_file(path, nrrd("3 4 3 2", "RGB-color domain domain domain", "none " + space,
                          alternating(3), is_deflated));
    expect_components(path, 3, 1, {"red", "green", "blue"});
    write_file(path, nrrd("4 3 2 3", "space space space list", space + " none",
                          volume(0) + volume(1) + volume(2), is_deflated));
    expect_components(path, 3, 1);
    write_file(path, nrrd("4 3 2 2", "domain domain domain time", "",
                          volume(0, 0) + volume(0, 1), is_deflated));
    expect_components(path, 1, 2);
    write_file(path, nrrd("2 4 3 2 2", "vector domain domain domain time",
                          "none " + space + " none", alternating(2, 0) + alternating(2, 1),
                          is_deflated));
    expect_components(path, 2, 2);
    write_file(path, nrrd("2 4 3 2", "", "none " + space, alternating(2), is_deflated));
    expect_components(path, 2, 1);
    write_file(path, nrrd("4 3 2 2 2", "space space space list time", space + " none none",
                          volume(0, 0) + volume(1, 0) + volume(0, 1) + volume(1, 1), is_deflated));
    expect_components(path, 2, 2);
  }
}

TEST(SourceComponents, OfNrrdThatAreNotToldApartAreRejected) {
  const TempFolder folder;
  const std::string space = "(1,0,0) (0,1,0) (0,0,1)";
  const std::vector<std::pair<std::string, std::string>> rows = {
      {nrrd("4 3 2 3", "", "", ""), "which axis"},
      {nrrd("4 3 2 3", "domain domain domain domain", "", ""), "which axis"},
      {nrrd("2 4 3 2", "complex domain domain domain", "none " + space, ""), "complex numbers"},
      {nrrd("4 2 3 2", "domain list domain domain", "", ""), "between the directions"},
      {nrrd("2 3 4 3 2", "list vector domain domain domain", "", ""), "both are channels"},
      {nrrd("3 4 3 2", "domain domain domain list", "none " + space, ""), "contradicts"},
      {nrrd("3 4 3 2", "domain domain", "", ""), "2 words for 4 axes"},
      {nrrd("3 4 3 2", "", space, ""), "4 axes expected, 3 found"}};
  for (const auto& [header, words] : rows) {
    write_file(folder.file("a.nrrd"), header + std::string(200, '\0'));
    const Error error = source_error({folder.file("a.nrrd")}, choose("0", 0));
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error, words)) << error.what();
  }
}

TEST(SourceComponents, OfMoreTimesThanCountsHoldAreRejected) {
  const TempFolder folder;
  const std::int64_t times = std::int64_t{1} << 62;
  write_file(folder.file("a.nrrd"), nrrd("4 3 2 3 " + std::to_string(times),
                                         "space space space list time", "", "voxels"));
  const Error error = source_error({folder.file("a.nrrd")}, choose("2", times - 1));
  EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  EXPECT_TRUE(contains(error, "channels and times exceed 63 bits")) << error.what();
}

TEST(SourceComponents, OfMetaImageAlternateOrFollowInTime) {
  const TempFolder folder;
  const std::string path = folder.file("a.mha");
  const std::string rest = "ElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
  write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementNumberOfChannels = 3\n" + rest +
                       alternating(3));
  expect_components(path, 3, 1);
  write_file(path, "NDims = 4\nDimSize = 4 3 2 2\nElementNumberOfChannels = 2\n" + rest +
                       alternating(2, 0) + alternating(2, 1));
  expect_components(path, 2, 2);
  write_file(path, "NDims = 4\nDimSize = 4 3 2 2\nElementSpacing = 1 2 3 4\nOffset = 5 6 7 8\n"
                   "TransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n" + rest + volume(0, 0) +
                       volume(0, 1));
  expect_components(path, 1, 2);
  SourceOptions options;
  options.time = 1;
  const auto source = open_source({path}, options);
  EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{1, 2, 3}));
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{5, 6, 7}));
  write_file(folder.file("b.raw"), "some header" + alternating(2));
  write_file(folder.file("b.mhd"), "NDims = 3\nDimSize = 4 3 2\nElementNumberOfChannels = 2\n"
                                   "HeaderSize = -1\nElementType = MET_UCHAR\n"
                                   "ElementDataFile = b.raw\n");
  expect_components(folder.file("b.mhd"), 2, 1);
}

/// Half of a volume: one of its two planes.
std::string plane(const std::string& voxels, int z) {
  return voxels.substr(static_cast<std::size_t>(z) * kVoxels / 2, kVoxels / 2);
}

TEST(SourceComponents, OfTiffStandInSamples) {
  const TempFolder folder;
  for (const std::uint32_t tile : {0U, 16U}) {
    for (const bool is_separate : {false, true}) {
      for (const int compression : {COMPRESSION_NONE, COMPRESSION_ADOBE_DEFLATE}) {
        TiffSample sample;
        sample.samples = 3;
        sample.separate = is_separate;
        sample.tile = tile;
        sample.compression = static_cast<std::uint16_t>(compression);
        sample.rows_per_strip = 2;
        const std::string all = alternating(3);
        for (const int z : {0, 1}) {
          sample.pages.push_back(is_separate ? plane(volume(0), z) + plane(volume(1), z) +
                                                   plane(volume(2), z)
                                             : all.substr(static_cast<std::size_t>(z) * 36, 36));
        }
        write_tiff(folder.file("a.tif"), sample);
        expect_components(folder.file("a.tif"), 3, 1, {"red", "green", "blue"});
      }
    }
  }
}

/// The pages of 2 channels, 2 planes and 2 times in an order such as "CZT", fastest first.
std::vector<std::string> pages_in_order(const std::string& order) {
  std::vector<std::string> pages;
  for (int i = 0; i < 8; ++i) {
    const auto index = [&](char axis) { return i >> order.find(axis) & 1; };
    pages.push_back(plane(volume(index('C'), index('T')), index('Z')));
  }
  return pages;
}

TEST(SourceComponents, OfTiffStandInPagesOfEveryOrder) {
  const TempFolder folder;
  TiffSample sample;
  sample.description = "ImageJ=1.53t\nimages=8\nchannels=2\nslices=2\nframes=2\nhyperstack=true\n";
  sample.pages = pages_in_order("CZT");
  write_tiff(folder.file("imagej.tif"), sample);
  expect_components(folder.file("imagej.tif"), 2, 2);
  for (const std::string order : {"CZT", "CTZ", "ZCT", "ZTC", "TCZ", "TZC"}) {
    sample.description = "<?xml version=\"1.0\"?><OME><Image><Pixels DimensionOrder=\"XY" + order +
                         "\" SizeZ=\"2\" SizeC=\"2\" SizeT=\"2\"></Pixels></Image></OME>";
    sample.pages = pages_in_order(order);
    write_tiff(folder.file("a.ome.tif"), sample);
    expect_components(folder.file("a.ome.tif"), 2, 2);
  }
}

TEST(SourceComponents, OfTiffThatItsPagesDoNotHoldAreRejected) {
  const TempFolder folder;
  const auto rejected = [&](const std::string& description, std::size_t pages) {
    TiffSample sample;
    sample.description = description;
    for (std::size_t i = 0; i < pages; ++i) sample.pages.push_back(plane(volume(0), 0));
    write_tiff(folder.file("a.tif"), sample);
    const Error error = source_error({folder.file("a.tif")}, choose("0", 0));
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << error.what();
    return std::string(error.what());
  };
  EXPECT_TRUE(contains(rejected("ImageJ=1.53t\nimages=5\nchannels=2\n", 5), "5 pages"));
  EXPECT_TRUE(contains(rejected("<OME><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"4\" SizeC=\"1\" "
                               "SizeT=\"1\"></Pixels></OME>", 3), "4 slices"));
  EXPECT_TRUE(contains(rejected("<OME><Pixels DimensionOrder=\"XYCCT\" SizeZ=\"2\" SizeC=\"2\" "
                               "SizeT=\"1\"></Pixels></OME>", 4), "once"));
  EXPECT_TRUE(contains(rejected("<OME><Pixels SizeZ=\"2\" SizeC=\"2\" SizeT=\"1\"></Pixels></OME>",
                               4), "order of pages"));
}

TEST(SourceComponents, OfPngAreItsColors) {
  const TempFolder folder;
  const std::vector<std::vector<std::string>> names = {
      {}, {}, {"grey", "alpha"}, {"red", "green", "blue"}, {"red", "green", "blue", "alpha"}};
  for (const auto& [channels, color_type] : {std::pair{2, 4}, {3, 2}, {4, 6}}) {
    const auto count = static_cast<std::size_t>(channels);
    const std::string all = alternating(channels);
    const std::string stack = "png" + std::to_string(channels);
    for (const int z : {0, 1}) {
      write_png(folder.file(stack + "/" + std::to_string(z) + ".png"), 4, 3, 8, color_type,
                all.substr(static_cast<std::size_t>(z) * 12 * count, 12 * count));
    }
    const std::string first = folder.file(stack + "/0.png");
    const Error none = source_error({folder.file(stack)}, choose(""));
    EXPECT_TRUE(contains(none, std::to_string(channels) + " channels")) << none.what();
    for (int channel = 0; channel < channels; ++channel) {
      const auto& name = names[count][static_cast<std::size_t>(channel)];
      EXPECT_EQ(voxels_of(*open_source({folder.file(stack)}, choose(name))), volume(channel));
    }
  }
}

TEST(SourceComponents, OfDicomAreItsColors) {
  const TempFolder folder;
  const std::string all = alternating(3);
  for (const std::uint16_t planar : {std::uint16_t{0}, std::uint16_t{1}}) {
    const std::string series = "dicom" + std::to_string(planar);
    for (const int z : {0, 1}) {
      DicomSample sample;
      sample.samples = 3;
      sample.planar = planar;
      sample.photometric = "RGB";
      sample.bits_allocated = 8;
      sample.bits_stored = 8;
      sample.high_bit = 7;
      sample.is_signed = 0;
      sample.position = "0\\0\\" + std::to_string(z);
      sample.voxels = planar == 1 ? plane(volume(0), z) + plane(volume(1), z) + plane(volume(2), z)
                                  : all.substr(static_cast<std::size_t>(z) * 36, 36);
      write_dicom(folder.file(series + "/" + std::to_string(z) + ".dcm"), sample);
    }
    const Error none = source_error({folder.file(series)}, choose(""));
    EXPECT_TRUE(contains(none, "3 channels (red, green, blue)")) << none.what();
    for (int channel = 0; channel < 3; ++channel) {
      const auto source = open_source({folder.file(series)}, choose(std::to_string(channel)));
      EXPECT_EQ(voxels_of(*source), volume(channel));
    }
  }
}

TEST(SourceComponents, AreRejectedWhereThereIsOnlyOne) {
  const TempFolder folder;
  write_nifti(folder.file("a.nii"), {4, 3, 2}, 2, volume(0));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii")}, choose("0", 0))), volume(0));
  for (const SourceOptions& wrong : {choose("1"), choose("red"), choose("", 1)}) {
    const Error error = source_error({folder.file("a.nii")}, wrong);
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument) << error.what();
  }
  EXPECT_FALSE(contains(open_source({folder.file("a.nii")}, {})->description().metadata.text(),
                        "chosen"));
}

}  // namespace
}  // namespace octavo::testing
