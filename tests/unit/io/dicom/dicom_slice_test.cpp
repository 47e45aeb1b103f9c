// What headers of DICOM files say about stored voxels and their meaning, and what cannot be taken.
#include <gtest/gtest.h>

#include <algorithm>

#include "support/coded_dicom.h"
#include "support/dicom_elements.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

constexpr std::uint32_t kFrames = 0x00280008;
constexpr std::uint32_t kModalityTable = 0x00283000;
constexpr std::uint32_t kDoseOffsets = 0x3004000c;
constexpr std::uint32_t kDoseScaling = 0x3004000e;

void expect_words(const std::string& text, const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
  }
}

/// The error of `elements` as a file, a error of the source.
void expect_error(const DicomElements& elements, const std::vector<std::string>& words,
                  const std::string& transfer_syntax = kExplicitLittle) {
  const TempFolder folder;
  elements.write(folder.file("a.dcm"), transfer_syntax);
  const Error error = source_error({folder.file("a.dcm")});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  expect_words(error.what(), words);
}

std::string swapped_pairs(std::string bytes) {
  for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) std::swap(bytes[at], bytes[at + 1]);
  return bytes;
}

/// 0, 1, 2, ... of 15 voxels a frame.
std::string counted(std::size_t count) {
  std::string bytes;
  for (std::size_t i = 0; i < count; ++i) bytes += static_cast<char>(i);
  return bytes;
}

TEST(SourceDicomWords, OfBigEndianFilesHoldTheFirstOfTwoBytesBehindTheSecond) {
  const TempFolder folder;
  for (const char* vr : {"OW", "OB"}) {
    DicomElements elements = ct_elements(5, 3, 8, 0, true);
    elements.set(kFrames, "IS", "3");
    // Frames of 15 bytes: the second starts in the middle of a word.
    const std::string voxels = counted(45) + std::string(1, '\0');
    elements.set(kPixelData, vr, vr == std::string("OW") ? swapped_pairs(voxels) : voxels);
    elements.write(folder.file("a.dcm"), kExplicitBig);
    const auto source = open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1));
    EXPECT_EQ(voxels_of(*source), counted(45)) << vr;
  }
}

TEST(SourceDicomWords, OfLittleEndianFilesStayAsTheyAre) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kPixelData, "OW", counted(15));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, {})), counted(15));
}

TEST(SourceDicomWords, OfBigEndianColorHoldSwappedSamples) {
  const TempFolder folder;
  for (const int planar : {0, 1}) {
    DicomElements elements = ct_elements(5, 3, 8, 0, true);
    elements.set_number(0x00280002, 3);
    elements.set(0x00280004, "CS", "RGB");
    elements.set_number(0x00280006, static_cast<std::uint16_t>(planar));
    elements.set(kPixelData, "OW", swapped_pairs(counted(45) + std::string(1, '\0')));
    elements.write(folder.file("a.dcm"), kExplicitBig);
    SourceOptions options;
    options.channel = "green";
    std::string green;
    for (int i = 0; i < 15; ++i) green += static_cast<char>(planar == 1 ? 15 + i : 3 * i + 1);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, options)), green) << planar;
  }
}

TEST(SourceDicomWords, OfBigEndianSegmentationsHoldSwappedBits) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 1, 0, true);
  elements.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4");
  elements.set(0x00080060, "CS", "SEG");
  elements.set(0x00620001, "CS", "BINARY");
  elements.set(kFrames, "IS", "3");
  // 45 bits: every third one of the frames behind one another.
  std::string packed(6, '\0');
  std::string labels(45, '\0');
  for (std::size_t i = 0; i < labels.size(); i += 3) {
    labels[i] = 1;
    packed[i / 8] = static_cast<char>(packed[i / 8] | 1 << i % 8);
  }
  elements.set(kPixelData, "OW", swapped_pairs(packed));
  elements.write(folder.file("a.dcm"), kExplicitBig);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1))), labels);
}

TEST(SourceDicomExtent, OfMorePicturesThanTheHeaderNamesIsRejected) {
  DicomElements grey = ct_elements(5, 3, 8);
  grey.set(kPixelData, "OB", counted(10 * 15));
  expect_error(grey, {"a.dcm", "10 pictures", "Number of Frames (0028,0008) says 1"});
  grey.set(kFrames, "IS", "2");
  grey.set(kPixelData, "OB", counted(3 * 15));
  expect_error(grey, {"3 pictures", "says 2"});
  DicomElements mask = ct_elements(5, 3, 1);
  mask.set(0x00080016, "UI", "1.2.840.10008.5.1.4.1.1.66.4");
  mask.set(0x00620001, "CS", "BINARY");
  mask.set(kPixelData, "OB", std::string(4, '\0'));
  expect_error(mask, {"2 pictures", "says 1"});
}

TEST(SourceDicomExtent, OfMoreBytesThanThePictureTakesIsToldInOneWarning) {
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) {
    DicomElements elements = ct_elements(5, 3, 8, 2 * z);
    elements.set(kPixelData, "OB", counted(z == 0 ? 16 : 22));
    elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
  }
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(voxels_of(*source), counted(15) + counted(15) + counted(15));
  ASSERT_EQ(source->warnings().size(), 1U);
  expect_words(with_hints(source->warnings()[0]),
               {"2 files hold more pixel data", "s1: 7 bytes more"});
}

TEST(SourceDicomExtent, OfMoreCompressedPicturesIsRejected) {
  const std::string jpeg = "\xff\xd8\xff\xe0";
  const std::string jpeg2000 = "\xff\x4f\xff\x51";
  const std::string middle = "\xff\x4f\x01\x02";
  const std::string runs("\x01\0\0\0\x40\0\0\0", 8);
  struct Row {
    const char* syntax;
    std::vector<std::string> fragments;
    bool has_table;
    const char* frames;
    const char* found;
  };
  for (const Row& row : std::vector<Row>{
           {kRunLengths, {runs, runs, runs}, false, "1", "3 pictures"},
           {kRunLengths, {runs, runs, runs}, true, "2", "3 pictures"},
           {kJpegBaseline, {jpeg, middle, jpeg}, false, "1", "2 pictures"},
           {kJpegBaseline, {jpeg, jpeg}, true, "1", "2 pictures"},
           {kJpeg2000, {jpeg2000, middle, jpeg2000, middle}, false, "1", "2 pictures"}}) {
    DicomElements elements = ct_elements(5, 3, 8);
    elements.set(kFrames, "IS", row.frames);
    elements.set_fragments(row.fragments, row.has_table);
    expect_error(elements, {row.found, std::string("says ") + row.frames}, row.syntax);
  }
}

TEST(SourceDicomExtent, OfOnePictureInSeveralFragmentsIsNoFault) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kPixelData, "OB", counted(15));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  const std::string coded =
      coded_picture_of(folder.file("a.dcm"), gdcm::TransferSyntax::JPEGLSLossless);
  // A table of the fragments instead of the frames is not what tells.
  for (const bool has_table : {false, true}) {
    elements.set_fragments({coded.substr(0, 16), coded.substr(16)}, has_table);
    elements.write(folder.file("a.dcm"), kJpegLs);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, {})), counted(15)) << has_table;
  }
}

TEST(SourceDicomExtent, OfFramesInSeveralFragmentsWithoutATableIsRead) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  std::vector<std::string> fragments;
  std::string expected;
  for (const std::string& values : {counted(15), std::string(15, '\7'), counted(15)}) {
    elements.set(kPixelData, "OB", values);
    elements.write(folder.file("a.dcm"), kExplicitLittle);
    const std::string coded =
        coded_picture_of(folder.file("a.dcm"), gdcm::TransferSyntax::JPEGLSLossless);
    fragments.insert(fragments.end(), {coded.substr(0, 16), coded.substr(16)});
    expected += values;
  }
  elements.set(kFrames, "IS", "3");
  // A table of the fragments is none of the frames.
  for (const bool has_table : {false, true}) {
    elements.set_fragments(fragments, has_table);
    elements.write(folder.file("a.dcm"), kJpegLs);
    EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1))), expected);
  }
  elements.set(kFrames, "IS", "4");
  expect_error(elements, {"4 frames, 6 compressed fragments", "starts of as many pictures"},
               kJpegLs);
}

TEST(SourceDicomExtent, OfANumberOfFramesThatIsNoneIsRejected) {
  for (const char* text : {"1A", "1.5", "2\\3", "0", "-1"}) {
    DicomElements elements = ct_elements(5, 3, 8);
    elements.set(kFrames, "IS", text);
    expect_error(elements, {"Number of Frames (0028,0008)", text});
  }
}

TEST(SourceDicomExtent, OfMoreRowsThanTheirNumberCanSayIsRejected) {
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(0x00280010, "UL", std::string("\0\0\1\0", 4));
  elements.set(0x00280011, "UL", std::string("\0\0\1\0", 4));
  expect_error(elements, {"65536 x 65536", "65535"});
}

TEST(SourceDicomValues, OfARescaleThatIsNoNumberAreRejected) {
  struct Row {
    std::uint32_t tag;
    const char* text;
  };
  for (const Row& row : std::vector<Row>{{kSlope, "2,5"},
                                         {kIntercept, "-1,024"},
                                         {kSlope, "two"},
                                         {kSlope, "1\\2"},
                                         {kIntercept, "1e999"},
                                         {kIntercept, "nan"}}) {
    DicomElements elements = ct_elements(5, 3, 8);
    elements.set(row.tag, "DS", row.text);
    const std::string name = row.tag == kSlope ? "Rescale Slope (0028,1053)"
                                               : "Rescale Intercept (0028,1052)";
    const std::string shown = row.text == std::string("1\\2") ? "1" : row.text;
    expect_error(elements, {"a.dcm", name + " is \"" + shown, "not one number"});
  }
}

TEST(SourceDicomValues, OfARescaleOfAnyLengthAreRejected) {
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kSlope, "DS", std::string(1000, 'x'));
  expect_error(elements, {"Rescale Slope (0028,1053)", "not one number"});
}

TEST(SourceDicomValues, WithABlankRescaleAreTheStoredOnes) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kSlope, "DS", "  ");
  elements.set(kIntercept, "DS", "");
  elements.set_items(kModalityTable, {});
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(open_source({folder.file("a.dcm")}, {})->description().rescale, Rescale{});
}

TEST(SourceDicomValues, OfATableAreRejectedUnlessAnotherSeriesIsTaken) {
  DicomElements table;
  table.set(0x00283004, "LO", "HU");
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set_items(kModalityTable, {table});
  expect_error(elements, {"a.dcm", "Modality LUT Sequence (0028,3000)", "not applied"});
  const TempFolder folder;
  elements.set(0x0020000e, "UI", "7.8");
  elements.write(folder.file("table.dcm"), kExplicitLittle);
  ct_elements(5, 3, 8).write(folder.file("plain.dcm"), kExplicitLittle);
  SourceOptions options;
  options.series = "1.2.3";
  EXPECT_EQ(open_source({folder.path()}, options)->description().size.z, 1);
}

/// Three frames with positions in functional groups.
DicomElements enhanced_elements() {
  DicomElements elements = ct_elements(5, 3, 8);
  std::vector<DicomElements> frames;
  for (int z = 0; z < 3; ++z) {
    DicomElements place;
    place.set(0x00200032, "DS", "0\\0\\" + std::to_string(2 * z));
    frames.emplace_back().set_items(0x00209113, {place});
  }
  DicomElements orientation;
  orientation.set(0x00200037, "DS", "1\\0\\0\\0\\1\\0");
  DicomElements measures;
  measures.set(0x00280030, "DS", "0.5\\0.5");
  DicomElements shared;
  shared.set_items(0x00209116, {orientation});
  shared.set_items(0x00289110, {measures});
  elements.set_items(0x52009229, {shared});
  elements.set_items(0x52009230, frames);
  elements.set(kFrames, "IS", "3");
  elements.set(kPixelData, "OB", counted(45));
  return elements;
}

TEST(SourceDicomValues, OfFramesWithoutATransformationAreThoseOfTheWholeFile) {
  const TempFolder folder;
  DicomElements elements = enhanced_elements();
  elements.set(kSlope, "DS", "2");
  elements.set(kIntercept, "DS", "-5");
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(open_source({folder.file("a.dcm")}, {})->description().rescale, (Rescale{2, -5}));
  DicomElements transformation;
  transformation.set(kSlope, "DS", "3");
  transformation.set(kIntercept, "DS", "7");
  DicomElements shared;
  shared.set_items(0x00289145, {transformation});
  elements.set_items(0x52009229, {shared});
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1))->description().rescale,
            (Rescale{3, 7}));
}

/// A dose of three planes at 10, 12.5 and 15 mm.
DicomElements dose_elements() {
  DicomElements elements = ct_elements(5, 3, 8, 10);
  elements.set(0x00080060, "CS", "RTDOSE");
  elements.set(kFrames, "IS", "3");
  elements.set(0x30040002, "CS", "GY");
  elements.set(kDoseOffsets, "DS", "0\\2.5\\5");
  elements.set(kDoseScaling, "DS", "0.001");
  elements.set(kPixelData, "OB", counted(45));
  return elements;
}

TEST(SourceDicomDose, IsScaledAndPlacedAsItsGridSays) {
  const TempFolder folder;
  DicomElements elements = dose_elements();
  for (const char* offsets : {"0\\2.5\\5", "10\\12.5\\15"}) {
    elements.set(kDoseOffsets, "DS", offsets);
    elements.write(folder.file("a.dcm"), kExplicitLittle);
    const auto source = open_source({folder.file("a.dcm")}, {});
    EXPECT_EQ(source->description().rescale, (Rescale{0.001, 0}));
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{0.5, 0.5, 2.5}));
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{0, 0, 10}));
    expect_words(source->description().metadata.text(), {"\"unit\":\"Gy\""});
    EXPECT_EQ(voxels_of(*source), counted(45));
  }
}

TEST(SourceDicomDose, SeenFromBelowIsPlacedByHeights) {
  const TempFolder folder;
  DicomElements elements = dose_elements();
  elements.set(0x00200037, "DS", "1\\0\\0\\0\\-1\\0");
  elements.set(kDoseOffsets, "DS", "10\\12.5\\15");
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  const auto source = open_source({folder.file("a.dcm")}, {});
  EXPECT_EQ(source->description().geometry.origin_mm, (Point3{0, 0, 15}));
  EXPECT_EQ(source->description().geometry.direction[8], -1);
  const std::string all = counted(45);
  EXPECT_EQ(voxels_of(*source), all.substr(30) + all.substr(15, 15) + all.substr(0, 15));
}

TEST(SourceDicomDose, OfManyPlanesIsPlacedByItsLongList) {
  const TempFolder folder;
  DicomElements elements = dose_elements();
  std::string offsets = "0";
  for (int i = 1; i < 300; ++i) offsets += "\\" + std::to_string(2.5 * i);
  elements.set(kFrames, "IS", "300");
  elements.set(kDoseOffsets, "DS", offsets);
  elements.set(kPixelData, "OB", std::string(4500, '\1'));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(open_source({folder.file("a.dcm")}, {})->description().size, (Size3{5, 3, 300}));
}

TEST(SourceDicomDose, WithoutAScaleOrAFittingGridIsRejected) {
  DicomElements elements = dose_elements();
  for (const char* scaling : {"", "0", "0,001"}) {
    elements.set(kDoseScaling, "DS", scaling);
    expect_error(elements, {"Dose Grid Scaling (3004,000e)"});
  }
  elements = dose_elements();
  const std::string name = "Grid Frame Offset Vector (3004,000c) ";
  for (const auto& [offsets, why] : std::vector<std::pair<const char*, std::string>>{
           {"0\\2.5", name + "has 2 numbers for 3 frames"},
           {"7\\9.5\\12", name + "starts with 7, 0 or the height of the position expected"},
           {"0\\x\\5", name + "has 0 numbers for 3 frames"}}) {
    elements.set(kDoseOffsets, "DS", offsets);
    expect_error(elements, {"no geometry", why});
  }
}

TEST(SourceDicomExtent, OfMoreGroupsThanFramesIsRejected) {
  DicomElements elements = enhanced_elements();
  elements.set(kFrames, "IS", "2");
  elements.set(kPixelData, "OB", counted(30));
  expect_error(elements, {"Per-frame Functional Groups Sequence (5200,9230) has 3 items",
                          "Number of Frames (0028,0008) says 2"});
}

TEST(SourceDicomValues, OfSlicesWithOtherUnitsOrFramesOfReferenceAreNotMixed) {
  struct Row {
    std::uint32_t tag;
    const char* vr;
    const char* first;
    const char* other;
    const char* word;
  };
  for (const Row& row : std::vector<Row>{{0x00281054, "LO", "HU", "OD", "unit of real values"},
                                         {0x00541001, "CS", "BQML", "CNTS", "unit of PET values"},
                                         {0x00200052, "UI", "1.2", "1.3", "frame of reference"}}) {
    const TempFolder folder;
    for (int z = 0; z < 3; ++z) {
      DicomElements elements = ct_elements(5, 3, 8, 2 * z);
      elements.set(row.tag, row.vr, z == 1 ? row.other : row.first);
      elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
    }
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    expect_words(error.what(), {"s0", "s1", row.word, row.first, row.other});
  }
}

TEST(SourceDicomValues, OfSlicesWithAFrameOfReferenceEachAreTaken) {
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) {
    DicomElements elements = ct_elements(5, 3, 8, 2 * z);
    elements.set(0x00200052, "UI", "1.2." + std::to_string(z));
    elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
  }
  EXPECT_EQ(open_source({folder.path()}, {})->description().size.z, 3);
}

/// Four slices of which every second has another value.
void write_alternating(const TempFolder& folder, std::uint32_t tag, const std::string& vr,
                       const std::vector<std::string>& values) {
  for (int z = 0; z < 4; ++z) {
    DicomElements elements = ct_elements(5, 3, 8, 2 * z);
    elements.set(tag, vr, values[static_cast<std::size_t>(z) % values.size()]);
    elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
  }
}

TEST(SourceDicomMixture, OfPatientsAndStudiesIsRejected) {
  const TempFolder folder;
  write_alternating(folder, 0x00100020, "LO", {"A17", "B18"});
  const Error error = source_error({folder.path()});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  expect_words(error.what(), {"Patient ID (0010,0020)", "s0", "s1"});
  EXPECT_FALSE(contains(error, "A17") || contains(error, "B18"));
  write_alternating(folder, 0x0020000d, "UI", {"1.2.3", "1.2.4"});
  expect_words(source_error({folder.path()}).what(), {"Study Instance UID", "1.2.3", "1.2.4"});
  write_alternating(folder, 0x0020000d, "UI", {"1.2.3", "1.2.4", "1.2.5", "1.2.6"});
  EXPECT_EQ(open_source({folder.path()}, {})->description().size.z, 4);
}

TEST(SourceDicomMixture, OfKernelsPositionsAndEchoesBringsAWarning) {
  struct Row {
    std::uint32_t tag;
    const char* vr;
    std::vector<std::string> values;
    const char* word;
  };
  const TempFolder folder;
  for (const Row& row : std::vector<Row>{
           {0x00181210, "SH", {"B30", "B70"}, "Convolution Kernel (0018,1210) is B30 in s0"},
           {0x00185100, "CS", {"HFS", "FFS"}, "Patient Position (0018,5100)"},
           {0x00180060, "DS", {"80", "120"}, "KVP (0018,0060) is 120 kV in s1 and 80 kV in s0"},
           {0x00180081, "DS", {"10", "20"}, "10 ms in s0 and 20 ms in s1"},
           {0x00180082, "DS", {"100", "900"}, "100 ms in s0 and 900 ms in s1"},
           {0x00181314, "DS", {"15", "5"}, "Flip Angle (0018,1314) is 15 degrees in s0"},
           {0x00189087, "FD", {bytes_of<double>({0}), bytes_of<double>({1000})},
            "0 s/mm2 in s0 and 1000 s/mm2 in s1"},
           {0x00200100, "IS", {"1", "2"}, "Temporal Position Identifier (0020,0100)"},
           {0x00080008, "CS", {"ORIGINAL\\PRIMARY\\M", "DERIVED\\PRIMARY\\P"},
            "Image Type (0008,0008) is M in s0 and P in s1"}}) {
    write_alternating(folder, row.tag, row.vr, row.values);
    const auto source = open_source({folder.path()}, {});
    ASSERT_EQ(source->warnings().size(), 1U) << row.word;
    EXPECT_TRUE(contains(source->warnings().front(), row.word));
  }
  write_alternating(folder, 0x00080008, "CS", {"ORIGINAL\\PRIMARY\\AXIAL",
                                               "DERIVED\\SECONDARY\\AXIAL\\ADD"});
  EXPECT_TRUE(open_source({folder.path()}, {})->warnings().empty());
  write_alternating(folder, 0x00180081, "DS", {"10", "10.02"});
  EXPECT_TRUE(open_source({folder.path()}, {})->warnings().empty());
}

TEST(SourceDicomValues, OfPetAreInItsUnits) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(0x00080060, "CS", "PT");
  for (const auto& [units, shown] : std::vector<std::pair<std::string, std::string>>{
           {"BQML", "\"unit\":\"Bq/mL\""}, {"GML", "\"unit\":\"g/mL\""},
           {"CNTS", "\"unit\":\"{counts}\""}}) {
    elements.set(0x00541001, "CS", units);
    elements.write(folder.file("a.dcm"), kExplicitLittle);
    expect_words(open_source({folder.file("a.dcm")}, {})->description().metadata.text(), {shown});
  }
}

TEST(SourceDicomExtent, OfTilesOfASlideIsRejected) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.set(kFrames, "IS", "4");
  elements.set(kPixelData, "OB", counted(60));
  elements.set(0x00480006, "UL", bytes_of<std::uint32_t>({10}));
  elements.set(0x00480007, "UL", bytes_of<std::uint32_t>({6}));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  expect_words(source_error({folder.file("a.dcm")}, with_spacing(1, 1, 1)).what(),
               {"4 frames are tiles of one picture"});
  elements.set(0x00480006, "UL", bytes_of<std::uint32_t>({5}));
  elements.set(0x00480007, "UL", bytes_of<std::uint32_t>({3}));
  elements.write(folder.file("a.dcm"), kExplicitLittle);
  EXPECT_EQ(open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1))->description().size.z, 4);
}

TEST(SourceDicomMixture, OfVolumesAtOnePlaceIsToldByWhatTellsThemApart) {
  struct Row {
    std::uint32_t tag;
    const char* vr;
    std::vector<std::string> values;
    const char* words;
  };
  const TempFolder folder;
  for (const Row& row : std::vector<Row>{
           {0x00180060, "DS", {"80", "140"}, "KVP (0018,0060) is 80 kV and 140 kV"},
           {0x00180081, "DS", {"10", "20"}, "Echo Time (0018,0081) is 10 ms and 20 ms"},
           {0x00181314, "DS", {"5", "15"}, "Flip Angle (0018,1314) is 5 degrees and 15 degrees"},
           {0x00200012, "IS", {"3", "four"}, "Acquisition Number (0020,0012) is 3 and four"}}) {
    for (std::size_t i = 0; i < 6; ++i) {
      DicomElements elements = ct_elements(5, 3, 8, 2.0 * static_cast<double>(i % 3));
      elements.set(row.tag, row.vr, row.values[i / 3]);
      elements.write(folder.file("s" + std::to_string(i)), kExplicitLittle);
    }
    const Error error = source_error({folder.path()});
    expect_words(error.what(), {"s0 and s3 lie at the same position", row.words});
    EXPECT_FALSE(contains(error, "drop_duplicates")) << error.what();
    // Copies are copies whatever they are called.
    SourceOptions options;
    options.drop_duplicates = true;
    EXPECT_EQ(open_source({folder.path()}, options)->description().size.z, 3) << row.words;
  }
}

TEST(SourceDicomMixture, OfMomentsIsToldOf) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.remove(0x00200032);
  elements.set(kFrames, "IS", "3");
  elements.set(kPixelData, "OB", counted(45));
  const auto is_told = [&](const std::vector<std::uint16_t>& pointer) {
    elements.set(0x00280009, "AT", bytes_of(pointer));
    elements.write(folder.file("a.dcm"), kExplicitLittle);
    const auto source = open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1));
    return contains(with_hints(source->warnings()), "follow one another in time");
  };
  EXPECT_TRUE(is_told({0x0018, 0x1063}));
  EXPECT_TRUE(is_told({0x0018, 0x1065}));
  EXPECT_FALSE(is_told({0x0018, 0x1060}));
}

TEST(SourceDicomNumbers, OfFramesInAStackTellTheirOrder) {
  const TempFolder folder;
  DicomElements elements = ct_elements(5, 3, 8);
  elements.remove(0x00200032);
  elements.set(kFrames, "IS", "3");
  elements.set(kPixelData, "OB", counted(45));
  const auto write = [&](const std::vector<std::uint32_t>& numbers) {
    std::vector<DicomElements> frames;
    for (const std::uint32_t number : numbers) {
      DicomElements content;
      content.set(0x00209057, "UL", bytes_of<std::uint32_t>({number}));
      frames.emplace_back().set_items(0x00209111, {content});
    }
    elements.set_items(0x52009230, frames);
    elements.write(folder.file("a.dcm"), kExplicitLittle);
  };
  const std::string all = counted(45);
  write({3, 1, 2});
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, with_spacing(1, 1, 1))),
            all.substr(15) + all.substr(0, 15));
  write({1, 2, 1});
  expect_words(source_error({folder.file("a.dcm")}, with_spacing(1, 1, 1)).what(),
               {"frame 1", "frame 3", "In-Stack Position Number (0020,9057), 1",
                "export one of them alone"});
}

TEST(SourceDicomNumbers, WithoutPositionsAreOneEachAndEven) {
  const TempFolder folder;
  const auto write = [&](const std::vector<int>& numbers) {
    for (std::size_t z = 0; z < numbers.size(); ++z) {
      DicomElements elements = ct_elements(5, 3, 8);
      elements.remove(0x00200032);
      elements.set(0x00200013, "IS", std::to_string(numbers[z]));
      elements.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
    }
  };
  write({1, 2, 2, 3});
  expect_words(source_error({folder.path()}, with_spacing(1, 1, 1)).what(),
               {"s1 and s2", "Instance Number (0020,0013), 2"});
  write({1, 2, 3, 5});
  const auto told = open_source({folder.path()}, with_spacing(1, 1, 1));
  const bool is_told = std::ranges::any_of(told->warnings(), [](const Warning& warning) {
    return contains(warning, "from 3 in s2 to 5 in s3");
  });
  EXPECT_TRUE(is_told);
  write({2, 4, 6, 8});
  EXPECT_EQ(open_source({folder.path()}, with_spacing(1, 1, 1))->warnings().size(), 1U);
}

}  // namespace
}  // namespace octavo::testing
