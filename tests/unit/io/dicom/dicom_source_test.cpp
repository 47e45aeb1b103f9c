#include <gdcmImageChangeTransferSyntax.h>
#include <gdcmImageReader.h>
#include <gdcmImageWriter.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "octavo/io/source/prefetch_source.h"
#include "support/dicom_elements.h"
#include "support/dicom_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

/// Twelve values that name their plane: 100 z + index.
std::vector<std::int16_t> plane_values(int z) {
  std::vector<std::int16_t> values;
  for (int i = 0; i < 12; ++i) values.push_back(static_cast<std::int16_t>(100 * z + i - 50));
  return values;
}

DicomSample slice(int z, double mm_per_slice = 2) {
  DicomSample sample;
  sample.position = "-10\\20\\" + std::to_string(z * mm_per_slice + 5);
  sample.voxels = bytes_of(plane_values(z));
  return sample;
}

/// Slices 0 .. count-1 under names whose order is not that of space, one of them in a sub-folder.
void write_series(const TempFolder& folder, int count) {
  for (int z = 0; z < count; ++z) {
    const std::string name =
        (z == 1 ? "deep/er/" : "") + std::string("IM") + std::to_string(97 - z);
    write_dicom(folder.file(name), slice(z));
  }
}

std::string expected_voxels(int count) {
  std::string all;
  for (int z = 0; z < count; ++z) all += bytes_of(plane_values(z));
  return all;
}

TEST(SourceDicom, PlanesComeInSpatialOrderWithStoredValues) {
  const TempFolder folder;
  write_series(folder, 5);
  write_file(folder.file("notes.txt"), "not a slice");
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().type, VoxelType::int16);
  EXPECT_EQ(source->description().size, (Size3{4, 3, 5}));
  EXPECT_EQ(voxels_of(*source), expected_voxels(5));
}

TEST(SourceDicom, AnEmptyFileAmongSlicesIsRejectedByItsName) {
  for (const char* name : {"IM90", "IM98", "scan.dcm"}) {
    const TempFolder folder;
    write_series(folder, 3);
    write_file(folder.file(name), "");
    const Error error = source_error({folder.path()});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    for (const char* part : {name, "the file is empty", "copy it again"})
      EXPECT_TRUE(contains(error, part)) << error.what();
  }
}

TEST(SourceDicom, FilesThatMayHaveBeenSlicesAreLeftOutWithOneWarning) {
  const TempFolder folder;
  write_series(folder, 3);
  write_file(folder.file("IM94"), std::string(600, '\0'));
  auto source = open_source({folder.path()}, {});
  EXPECT_EQ(voxels_of(*source), expected_voxels(3));
  EXPECT_EQ(source->warnings(),
            std::vector<Warning>{"1 file that is not DICOM left out: IM94"});
  write_file(folder.file("notes.bak"), "what is this");
  source = open_source({folder.path()}, {});
  EXPECT_EQ(source->warnings(),
            std::vector<Warning>{"2 files that are not DICOM left out, among them IM94"});
}

TEST(SourceDicom, CompanionsOfAScanAreLeftOutWithoutAWord) {
  const TempFolder folder;
  write_series(folder, 3);
  for (const char* name : {"notes.txt", "REPORT.PDF", "AUTORUN.INF", "a.json", "viewer.exe",
                           "Thumbs.db", "README", "License", "VERSION", ".DS_Store"}) {
    write_file(folder.file(name), name);
  }
  write_file(folder.file("empty.log"), "");
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(voxels_of(*source), expected_voxels(3));
  EXPECT_TRUE(source->warnings().empty());
}

TEST(SourceDicom, GeometryRescaleAndUnitAreThoseOfTheHeaders) {
  const TempFolder folder;
  write_series(folder, 3);
  const auto source = open_source({folder.path()}, {});
  const VolumeDescription& d = source->description();
  EXPECT_EQ(d.geometry.spacing_mm, (Point3{0.25, 0.5, 2}));
  EXPECT_EQ(d.geometry.origin_mm, (Point3{-10, 20, 5}));
  EXPECT_EQ(d.geometry.direction, (std::array<double, 9>{1, 0, 0, 0, 1, 0, 0, 0, 1}));
  EXPECT_EQ(d.rescale, (Rescale{1, -1024}));
  EXPECT_TRUE(contains(d.metadata.text(), "\"unit\":\"[hnsf'U]\"")) << d.metadata.text();
  EXPECT_TRUE(source->warnings().empty());
}

TEST(SourceDicom, NothingThatNamesAPatientEntersTheMetadata) {
  const TempFolder folder;
  write_series(folder, 2);
  const std::string json = open_source({folder.path()}, {})->description().metadata.text();
  EXPECT_FALSE(contains(json, "Nemo")) << json;
  EXPECT_FALSE(contains(json, "1.2.3")) << json;
}

TEST(SourceDicom, TheNormalIsTheCrossProductOfRowsAndColumns) {
  const TempFolder folder;
  for (int z = 0; z < 3; ++z) {
    DicomSample sample = slice(z);
    sample.orientation = "1\\0\\0\\0\\-1\\0";
    write_dicom(folder.file("s" + std::to_string(z)), sample);
  }
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().geometry.origin_mm[2], 9);
  EXPECT_EQ(source->description().geometry.direction[8], -1);
  const std::string reversed =
      bytes_of(plane_values(2)) + bytes_of(plane_values(1)) + bytes_of(plane_values(0));
  EXPECT_EQ(voxels_of(*source), reversed);
}

TEST(SourceDicom, UnusedBitsAreMaskedAndTheSignExtended) {
  const TempFolder folder;
  DicomSample sample = slice(0);
  sample.bits_stored = 12;
  sample.high_bit = 11;
  std::vector<std::int16_t> junk(12, static_cast<std::int16_t>(0xaf0f));
  junk[1] = 0x57ff;
  sample.voxels = bytes_of(junk);
  write_dicom(folder.file("a.dcm"), sample);
  std::vector<std::int16_t> expected(12, -241);
  expected[1] = 0x7ff;
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.dcm")}, {})), bytes_of(expected));
}

TEST(SourceDicom, CompressedSlicesHoldTheSameVoxels) {
  const TempFolder folder;
  write_series(folder, 1);
  for (const auto syntax : {gdcm::TransferSyntax::JPEGLSLossless, gdcm::TransferSyntax::RLELossless,
                            gdcm::TransferSyntax::JPEGLosslessProcess14_1}) {
    gdcm::ImageReader reader;
    reader.SetFileName(folder.file("IM97").c_str());
    ASSERT_TRUE(reader.Read());
    gdcm::ImageChangeTransferSyntax change;
    change.SetTransferSyntax(syntax);
    change.SetInput(reader.GetImage());
    ASSERT_TRUE(change.Change());
    gdcm::ImageWriter writer;
    writer.SetFile(reader.GetFile());
    writer.SetImage(change.GetOutput());
    writer.SetFileName(folder.file("coded.dcm").c_str());
    ASSERT_TRUE(writer.Write());
    EXPECT_EQ(voxels_of(*open_source({folder.file("coded.dcm")}, {})), expected_voxels(1));
  }
}

TEST(SourceDicom, SeveralSeriesAreListedAndOneIsChosenByItsUid) {
  const TempFolder folder;
  write_series(folder, 3);
  DicomSample other = slice(0);
  other.series = "9.9.9";
  other.modality = "PT";
  write_dicom(folder.file("other"), other);
  const Error error = source_error({folder.path()});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  for (const char* part :
       {"2 series", "1.2.3: 3 slices of 4 x 3, CT", "9.9.9: 1 slice", "[series]"}) {
    EXPECT_TRUE(contains(error, part)) << error.what();
  }
  SourceOptions options;
  options.series = "1.2.3";
  EXPECT_EQ(voxels_of(*open_source({folder.path()}, options)), expected_voxels(3));
  options.series = "7";
  EXPECT_TRUE(contains(source_error({folder.path()}, options), "no series 7 here"));
}

/// A change to slice 2 of four, and the words the error must hold.
struct Flaw {
  const char* name;
  std::function<void(DicomSample&)> change;
  std::vector<std::string> words;
};

class SourceDicomFlaw : public ::testing::TestWithParam<Flaw> {};

TEST_P(SourceDicomFlaw, IsRejectedWithBothValues) {
  const TempFolder folder;
  for (int z = 0; z < 4; ++z) {
    DicomSample sample = slice(z);
    if (z == 2) GetParam().change(sample);
    write_dicom(folder.file("s" + std::to_string(z)), sample);
  }
  const Error error = source_error({folder.path()});
  EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
  for (const std::string& word : GetParam().words)
    EXPECT_TRUE(contains(error, word)) << error.what();
}

INSTANTIATE_TEST_SUITE_P(
    Slices, SourceDicomFlaw,
    ::testing::Values(
        Flaw{"Size",
             [](DicomSample& s) {
               s.rows = 4;
               s.voxels.clear();
             },
             {"s2", "s0", "4 x 4", "4 x 3"}},
        Flaw{"Type", [](DicomSample& s) { s.is_signed = 0; }, {"s2", "s0", "signed", "unsigned"}},
        Flaw{"Orientation",
             [](DicomSample& s) { s.orientation = "0.8\\0.6\\0\\-0.6\\0.8\\0"; },
             {"s2", "s0", "orientation", "0.6"}},
        Flaw{"PixelSpacing",
             [](DicomSample& s) { s.pixel_spacing = "0.5\\0.3"; },
             {"s2", "s0", "0.3", "0.25"}},
        Flaw{"Rescale", [](DicomSample& s) { s.slope = "1.5"; }, {"s2", "s0", "1.5 x", "1 x"}},
        Flaw{"Photometric",
             [](DicomSample& s) { s.photometric = "MONOCHROME1"; },
             {"s2", "s0", "MONOCHROME1", "MONOCHROME2"}},
        Flaw{"Duplicate",
             [](DicomSample& s) { s.position = "-10\\20\\7"; },
             {"s1", "s2", "same position", "7 mm"}},
        Flaw{"Gap",
             [](DicomSample& s) { s.position = "-10\\20\\13"; },
             {"s1", "s3", "4 mm", "2 mm", "missing"}},
        Flaw{"Uneven", [](DicomSample& s) { s.position = "-10\\20\\9.5"; }, {"s1", "s2", "2.5 mm"}},
        Flaw{"SidewaysShift",
             [](DicomSample& s) { s.position = "-9\\20\\9"; },
             {"sideways", "1 mm"}},
        Flaw{"NoGeometry", [](DicomSample& s) { s.position.reset(); }, {"s2"}},
        Flaw{"Color",
             [](DicomSample& s) {
               s.samples = 3;
               s.photometric = "RGB";
               s.voxels.clear();
             },
             {"3 samples", "1 sample"}},
        Flaw{"BadUnit",
             [](DicomSample& s) {
               s.bits_allocated = 64;
               s.voxels.clear();
             },
             {"64 bits"}},
        Flaw{"ShortVoxels", [](DicomSample& s) { s.voxels.resize(20); }, {"s2", "20 bytes", "24"}}),
    [](const auto& row) { return std::string(row.param.name); });

TEST(SourceDicom, GantryTiltIsRejectedWithItsAngle) {
  const TempFolder folder;
  for (int z = 0; z < 4; ++z) {
    DicomSample sample = slice(z);
    const double shift = 20 + z * 2 * std::tan(18.5 * M_PI / 180);
    sample.position = "-10\\" + std::to_string(shift) + "\\" + std::to_string(2 * z);
    write_dicom(folder.file("s" + std::to_string(z)), sample);
  }
  const Error error = source_error({folder.path()});
  EXPECT_TRUE(contains(error, "18.5 degrees")) << error.what();
}

TEST(SourceDicom, RoundedPositionsWithinTheToleranceAreAccepted) {
  const TempFolder folder;
  for (int z = 0; z < 4; ++z) {
    DicomSample sample = slice(z);
    sample.position = "-10\\20\\" + std::to_string(2 * z + (z % 2) * 0.004);
    write_dicom(folder.file("s" + std::to_string(z)), sample);
  }
  EXPECT_EQ(open_source({folder.path()}, {})->description().size.z, 4);
}

TEST(SourceDicom, PicturesThatMayTellWhoItIsBringAWarning) {
  for (const auto& [tag, words] : std::map<std::uint32_t, std::string>{
           {0x00280301, "text is burned into the picture"},
           {0x00280302, "the picture may show who it is"}}) {
    for (const char* value : {"YES", "NO"}) {
      const TempFolder folder;
      for (int z = 0; z < 3; ++z) {
        DicomElements slice = ct_elements(3, 2, 8, z);
        slice.set(tag, "CS", z == 1 ? value : "NO");
        slice.write(folder.file("s" + std::to_string(z)), kExplicitLittle);
      }
      const auto source = open_source({folder.path()}, {});
      ASSERT_EQ(source->warnings().size(), value == std::string("YES") ? 1U : 0U);
      if (source->warnings().empty()) continue;
      EXPECT_TRUE(contains(source->warnings().front(), words));
      EXPECT_TRUE(contains(source->warnings().front(), "s1"));
    }
  }
}

TEST(SourceDicom, EveryTruncationIsRejected) {
  const TempFolder folder;
  write_series(folder, 1);
  const std::string whole = read_file(folder.file("IM97"));
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_file(folder.file("cut.dcm"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file("cut.dcm")}).kind(), ErrorKind::source_rejected) << length;
  }
}

TEST(SourceDicom, SlicesWithoutGeometryAreReadOnlyWithASpacing) {
  const TempFolder folder;
  DicomSample sample = slice(0);
  sample.position.reset();
  write_dicom(folder.file("a.dcm"), sample);
  EXPECT_TRUE(contains(source_error({folder.file("a.dcm")}), "[spacing_mm]"));
}

TEST(SourceDicom, ReadingAheadWithAnyNumberOfThreadsGivesTheSamePlanes) {
  const TempFolder folder;
  write_series(folder, 23);
  for (const int threads : {1, 2, 5, 40}) {
    const auto source = make_prefetch_source(open_source({folder.path()}, {}), {threads});
    EXPECT_EQ(voxels_of(*source), expected_voxels(23)) << threads;
  }
}

TEST(SourceDicom, ReadingAheadThrowsWhereThePlaneIsAskedFor) {
  const TempFolder folder;
  write_series(folder, 9);
  const auto source = make_prefetch_source(open_source({folder.path()}, {}), {3, 100});
  write_file(folder.file("IM89"), "gone");
  std::string plane(24, '\0');
  for (int z = 0; z < 8; ++z) source->read_plane(std::as_writable_bytes(std::span(plane)));
  const Error error =
      error_of([&] { source->read_plane(std::as_writable_bytes(std::span(plane))); });
  EXPECT_TRUE(contains(error, "IM89")) << error.what();
}

TEST(SourceDicom, ReadingAheadCanBeAbandoned) {
  const TempFolder folder;
  write_series(folder, 9);
  const auto source = make_prefetch_source(open_source({folder.path()}, {}), {4, 100});
}

}  // namespace
}  // namespace octavo::testing
