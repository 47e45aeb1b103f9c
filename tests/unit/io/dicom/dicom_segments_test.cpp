#include "octavo/io/dicom/dicom_segments.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "support/dicom_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Two segments with a frame each at heights of 0 and 2 mm, which share no voxel unless asked to.
SegmentationSample two_segments(bool overlap) {
  SegmentationSample sample;
  sample.positions = {"0\\0\\0", "0\\0\\2", "0\\0\\0", "0\\0\\2"};
  sample.segments = {1, 1, 2, 2};
  sample.voxels.assign(60, false);
  sample.voxels[3] = true;
  sample.voxels[15] = true;
  sample.voxels[30 + 7] = true;
  sample.voxels[45 + 14] = true;
  if (overlap) sample.voxels[45] = true;
  return sample;
}

/// Voxels of 2 planes of 5 x 3 with some set.
std::string plane_pair(const std::vector<std::pair<std::size_t, char>>& set) {
  std::string voxels(30, '\0');
  for (const auto& [at, value] : set) voxels[at] = value;
  return voxels;
}

TEST(DicomSegments, OfOneFileBecomeTheLabelsOfOneVolume) {
  const TempFolder folder;
  write_segmentation(folder.file("seg.dcm"), two_segments(false));
  const auto source = open_source({folder.file("seg.dcm")}, {});
  EXPECT_EQ(source->description().kind, VolumeKind::labels);
  EXPECT_EQ(source->description().size, (Size3{5, 3, 2}));
  EXPECT_EQ(voxels_of(*source), plane_pair({{3, 1}, {7, 2}, {15, 1}, {29, 2}}));
  const auto metadata = nlohmann::json::parse(source->description().metadata.text());
  EXPECT_EQ(metadata["segments"], nlohmann::json({{{"number", 1}}, {{"number", 2}}}));
}

TEST(DicomSegments, KeepTheirLabelsOnlyWhereThatIsAskedFor) {
  const TempFolder folder;
  write_segmentation(folder.file("seg.dcm"), two_segments(false));
  SourceOptions options;
  for (const char* segment : {"", "part 2"}) {
    options.segment = segment;
    options.keep_identity = false;
    const std::string dropped =
        open_source({folder.file("seg.dcm")}, options)->description().metadata.text();
    EXPECT_FALSE(contains(dropped, "part ")) << dropped;
    EXPECT_EQ(nlohmann::json::parse(dropped)["identity"]["dropped"]["SegmentLabel"], 2);
    options.keep_identity = true;
    const auto kept = nlohmann::json::parse(
        open_source({folder.file("seg.dcm")}, options)->description().metadata.text());
    EXPECT_EQ(kept["identity"]["attributes"]["SegmentLabel"], "1 part 1\n2 part 2");
    EXPECT_FALSE(kept["identity"]["dropped"].contains("SegmentLabel"));
  }
}

/// The labels in the metadata of the segmentation, or of one segment of it.
nlohmann::json labels_of(const TempFolder& folder, const SegmentationSample& sample,
                         const std::string& segment) {
  write_segmentation(folder.file("seg.dcm"), sample);
  SourceOptions options;
  options.segment = segment;
  const auto source = open_source({folder.file("seg.dcm")}, options);
  return nlohmann::json::parse(source->description().metadata.text())["labels"];
}

TEST(DicomSegments, HaveTheColorsThatTheyAreRecommendedIn) {
  const TempFolder folder;
  const nlohmann::json red = {{"color", "#ff0000"}};
  const nlohmann::json green = {{"color", "#008040"}};
  SegmentationSample sample = two_segments(false);
  EXPECT_TRUE(labels_of(folder, sample, "").is_null());
  sample.colors = {{34886, 53484, 50172}, {30619, 21203, 39669}};
  EXPECT_EQ(labels_of(folder, sample, ""), (nlohmann::json{{"1", red}, {"2", green}}));
  EXPECT_EQ(labels_of(folder, sample, "2"), (nlohmann::json{{"1", green}}));
  SegmentationSample fractions = sample;
  fractions.type = "FRACTIONAL";
  fractions.fractions = std::string(60, 'a');
  EXPECT_TRUE(labels_of(folder, fractions, "2").is_null());
  SegmentationSample only = sample;
  only.positions.resize(2);
  only.segments = {2, 2};
  only.voxels.resize(30);
  EXPECT_EQ(labels_of(folder, only, ""), (nlohmann::json{{"1", green}}));

  SegmentationSample map = sample;
  map.type = "LABELMAP";
  map.positions.resize(2);
  map.numbers = {7, 200};
  map.labels = std::string(29, '\7') + '\xc8';
  EXPECT_EQ(labels_of(folder, map, ""), (nlohmann::json{{"7", red}, {"200", green}}));
  EXPECT_EQ(labels_of(folder, map, "200"), (nlohmann::json{{"1", green}}));
}

TEST(DicomSegments, AreTakenOneByOneByNumberOrLabel) {
  const TempFolder folder;
  write_segmentation(folder.file("seg.dcm"), two_segments(true));
  const std::vector<std::pair<std::string, std::string>> rows = {
      {"1", plane_pair({{3, 1}, {15, 1}})},
      {"part 1", plane_pair({{3, 1}, {15, 1}})},
      {"2", plane_pair({{7, 1}, {15, 1}, {29, 1}})},
      {"Part 2", plane_pair({{7, 1}, {15, 1}, {29, 1}})}};
  for (const auto& [name, voxels] : rows) {
    SourceOptions options;
    options.segment = name;
    const auto source = open_source({folder.file("seg.dcm")}, options);
    EXPECT_EQ(voxels_of(*source), voxels) << name;
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"segment\":{\"number\":"));
  }
  SourceOptions wrong;
  wrong.segment = "liver";
  const Error error = source_error({folder.file("seg.dcm")}, wrong);
  EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
  EXPECT_TRUE(contains(error, "1 part 1, 2 part 2")) << error.what();
}

TEST(DicomSegments, TakenAloneKeepThePlanesOfAll) {
  const TempFolder folder;
  SegmentationSample sample;
  // The second segment has a frame in the middle alone, a little beside that of the first.
  sample.positions = {"0\\0\\0", "0\\0\\2", "0\\0\\4", "0\\0\\2.0001"};
  sample.segments = {1, 1, 1, 2};
  sample.voxels.assign(60, true);
  write_segmentation(folder.file("seg.dcm"), sample);
  SourceOptions options;
  options.segment = "2";
  const auto source = open_source({folder.file("seg.dcm")}, options);
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{0, 0, 0}));
  EXPECT_EQ(voxels_of(*source),
            std::string(15, '\0') + std::string(15, '\1') + std::string(15, '\0'));
  sample.type = "FRACTIONAL";
  sample.fractions = std::string(60, 'a');
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("seg.dcm")}, options)),
            std::string(15, '\0') + std::string(15, 'a') + std::string(15, '\0'));
}

TEST(DicomSegments, ThatOverlapAreRejectedWithBothNames) {
  const TempFolder folder;
  SegmentationSample sample = two_segments(true);
  for (const char* said : {"", "NO", "YES"}) {
    sample.overlap = said;
    write_segmentation(folder.file("seg.dcm"), sample);
    const Error error = source_error({folder.file("seg.dcm")});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const char* word : {"1 part 1", "2 part 2", "overlap", "[segment=a number or label]"}) {
      EXPECT_TRUE(contains(error, word)) << error.what();
    }
  }
}

TEST(DicomSegments, OfFractionsAreGrey) {
  const TempFolder folder;
  SegmentationSample sample = two_segments(false);
  sample.type = "FRACTIONAL";
  for (int i = 0; i < 60; ++i) sample.fractions += static_cast<char>(3 * i);
  write_segmentation(folder.file("seg.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("seg.dcm")}), "[segment=a number or label]"));
  SourceOptions options;
  options.segment = "2";
  const auto source = open_source({folder.file("seg.dcm")}, options);
  EXPECT_EQ(source->description().kind, VolumeKind::grey);
  EXPECT_EQ(source->description().rescale, (Rescale{1.0 / 200, 0}));
  EXPECT_EQ(voxels_of(*source), sample.fractions.substr(30));
}

/// A label map of 2 planes whose voxels are 0 and the numbers 2 and 7; 7 is also its padding value
/// where that is asked for.
SegmentationSample label_map(std::uint16_t bits) {
  SegmentationSample sample;
  sample.type = "LABELMAP";
  sample.positions = {"0\\0\\2", "0\\0\\0"};
  sample.numbers = {0, 2, 7};
  sample.label_bits = bits;
  for (int i = 0; i < 30; ++i) {
    sample.labels += static_cast<char>(i == 3 || i == 20 ? 2 : i == 7 ? 7 : 0);
    if (bits == 16) sample.labels += '\0';
  }
  return sample;
}

TEST(DicomSegments, OfLabelMapsAreTheirNumbers) {
  const TempFolder folder;
  for (const std::uint16_t bits : {std::uint16_t{8}, std::uint16_t{16}}) {
    SegmentationSample sample = label_map(bits);
    if (bits == 16) sample.padding = 0;
    write_segmentation(folder.file("map.dcm"), sample);
    const auto source = open_source({folder.file("map.dcm")}, {});
    EXPECT_EQ(source->description().kind, VolumeKind::labels);
    EXPECT_EQ(source->description().type, bits == 8 ? VoxelType::uint8 : VoxelType::uint16);
    EXPECT_FALSE(source->description().padding);
    const std::size_t plane = sample.labels.size() / 2;
    EXPECT_EQ(voxels_of(*source), sample.labels.substr(plane) + sample.labels.substr(0, plane));
    const auto metadata = nlohmann::json::parse(source->description().metadata.text());
    EXPECT_EQ(metadata["segments"], nlohmann::json({{{"number", 2}}, {{"number", 7}}}));
  }
  SourceOptions options;
  options.keep_identity = true;
  const auto kept = nlohmann::json::parse(
      open_source({folder.file("map.dcm")}, options)->description().metadata.text());
  EXPECT_EQ(kept["identity"]["attributes"]["SegmentLabel"], "0 part 0\n2 part 2\n7 part 7");
}

TEST(DicomSegments, OfLabelMapsAreTakenOneByOne) {
  const TempFolder folder;
  write_segmentation(folder.file("map.dcm"), label_map(8));
  for (const char* segment : {"7", "part 7"}) {
    SourceOptions options;
    options.segment = segment;
    const auto source = open_source({folder.file("map.dcm")}, options);
    EXPECT_EQ(source->description().kind, VolumeKind::labels);
    EXPECT_EQ(voxels_of(*source), plane_pair({{22, 1}}));
    EXPECT_TRUE(contains(source->description().metadata.text(), "\"segment\":{\"number\":7"));
  }
  SourceOptions wrong;
  wrong.segment = "part 0";
  EXPECT_TRUE(contains(source_error({folder.file("map.dcm")}, wrong), "are 2 part 2, 7 part 7"));
}

TEST(DicomSegments, OfLabelMapsLeaveTheBackgroundZero) {
  const TempFolder folder;
  SegmentationSample sample = label_map(8);
  sample.padding = 7;
  sample.numbers = {2, 7};
  write_segmentation(folder.file("map.dcm"), sample);
  EXPECT_EQ(voxels_of(*open_source({folder.file("map.dcm")}, {})),
            plane_pair({{5, 2}, {18, 2}}));
  sample.numbers = {0, 2};
  write_segmentation(folder.file("map.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("map.dcm")}), "[segment=a number or label]"));
  SourceOptions options;
  options.segment = "0";
  EXPECT_EQ(voxels_of(*open_source({folder.file("map.dcm")}, options)).substr(0, 6),
            std::string("\1\1\1\1\1\0", 6));
}

TEST(DicomSegments, OfLabelMapsAreNotMixedBetweenSlices) {
  const TempFolder folder;
  SegmentationSample sample = label_map(8);
  sample.positions = {"0\\0\\0", "0\\0\\2", "0\\0\\6"};
  sample.labels = std::string(15, 2) + std::string(15, 4) + std::string(15, 8);
  sample.numbers = {2, 4, 8};
  write_segmentation(folder.file("map.dcm"), sample);
  SourceOptions options;
  options.on_gap = GapPolicy::fill;
  // A plane that is left out is empty, as in other segmentations.
  EXPECT_EQ(voxels_of(*open_source({folder.file("map.dcm")}, options)),
            std::string(15, 2) + std::string(15, 4) + std::string(15, 0) + std::string(15, 8));
}

TEST(DicomSegments, AreOfSegmentationsOnly) {
  const TempFolder folder;
  DicomSample slice;
  slice.position = "0\\0\\0";
  write_dicom(folder.file("ct.dcm"), slice);
  write_file(folder.file("a.raw"), "12345678");
  SourceOptions options;
  options.segment = "1";
  EXPECT_EQ(source_error({folder.file("ct.dcm")}, options).kind(), ErrorKind::invalid_argument);
  options.raw = parse_raw_layout("2,2,2,uint8");
  EXPECT_EQ(source_error({folder.file("a.raw")}, options).kind(), ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo::testing
