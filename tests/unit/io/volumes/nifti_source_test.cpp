#include <gtest/gtest.h>
#include <zlib.h>

#include <filesystem>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

const std::vector<std::int16_t> kValues = {0,  1,  -2, 300, -32768, 32767, 6,  7,  8,  9,  10, 11,
                                           12, 13, 14, 15,  16,     17,    18, 19, 20, 21, 22, 23};

TEST(SourceVolume, NiftiGivesStoredVoxelsAndLpsGeometry) {
  const TempFolder folder;
  for (const bool big_endian : {false, true}) {
    NiftiSample sample;
    sample.big_endian = big_endian;
    sample.slope = 0.1F;
    sample.intercept = -3;
    const std::string bytes = nifti_header(sample) + bytes_of(kValues, big_endian);
    for (const std::string& name : {std::string("a.nii"), std::string("b.nii.gz")}) {
      write_file(folder.file(name), name.ends_with("gz") ? gzip(bytes) : bytes);
      const auto source = open_source({folder.file(name)}, {});
      const VolumeDescription& d = source->description();
      EXPECT_EQ(d.size, (Size3{4, 3, 2}));
      EXPECT_EQ(d.geometry.spacing_mm, (Point3{2, 3, 4}));
      EXPECT_EQ(d.geometry.origin_mm, (Point3{-10, -20, 30}));
      EXPECT_EQ(d.geometry.direction, (std::array<double, 9>{-1, 0, 0, 0, -1, 0, 0, 0, 1}));
      EXPECT_EQ(d.rescale, (Rescale{static_cast<double>(0.1F), -3}));
      EXPECT_EQ(voxels_of(*source), bytes_of(kValues));
      EXPECT_TRUE(source->warnings().empty());
    }
  }
}

TEST(SourceVolume, NiftiLabelIntentMakesLabels) {
  const TempFolder folder;
  NiftiSample sample;
  sample.intent = 1002;
  write_file(folder.file("a.nii"), nifti_header(sample) + bytes_of(kValues));
  EXPECT_EQ(open_source({folder.file("a.nii")}, {})->description().kind, VolumeKind::labels);
}

TEST(SourceVolume, NiftiPairIsReadFromItsOwnFolder) {
  const TempFolder folder;
  std::string header = nifti_header({});
  header.replace(344, 4, std::string("ni1\0", 4));
  header.replace(108, 4, bytes_of<float>({0}));
  write_file(folder.file("a.hdr"), header);
  EXPECT_TRUE(contains(source_error({folder.file("a.hdr")}).what(), "a.img"));
  write_file(folder.file("a.img"), bytes_of(kValues));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.hdr")}, {})), bytes_of(kValues));
}

TEST(SourceVolume, ASiblingIsNeverReadInsteadOfTheFileNamed) {
  const TempFolder folder;
  write_file(folder.file("a.nii"), nifti_header({}) + bytes_of(kValues));
  EXPECT_EQ(source_error({folder.file("a.nii.gz")}).kind(), ErrorKind::io);
  EXPECT_EQ(source_error({folder.file("a")}).kind(), ErrorKind::io);
}

TEST(SourceVolume, NiftiThatIsNoScalarVolumeIsRefusedByName) {
  const TempFolder folder;
  const std::vector<std::pair<std::int16_t, std::string>> types = {
      {128, "3 channels (red, green, blue)"}, {2304, "alpha"}, {32, "complex"}, {64, "float 64"},
      {1024, "int 64"}, {1, "1 bit"},   {77, "77"}};
  for (const auto& [datatype, word] : types) {
    NiftiSample sample;
    sample.datatype = datatype;
    write_file(folder.file("a.nii"), nifti_header(sample) + std::string(1000, '\0'));
    const Error error = source_error({folder.file("a.nii")});
    EXPECT_EQ(error.kind(), ErrorKind::source_rejected);
    EXPECT_TRUE(contains(error.what(), word)) << error.what();
  }
  NiftiSample sample;
  sample.size = {4, 3, 2, 5};
  write_file(folder.file("a.nii"), nifti_header(sample) + std::string(1000, '\0'));
  EXPECT_TRUE(contains(source_error({folder.file("a.nii")}).what(), "5 points in time"));
}

void expect_every_truncation_refused(const TempFolder& folder, const std::string& name,
                                     const std::string& whole) {
  for (std::size_t length = 0; length < whole.size(); ++length) {
    write_file(folder.file(name), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file(name)}).kind(), ErrorKind::source_rejected)
        << name << " " << length;
  }
}

TEST(SourceVolume, EveryTruncationIsRefused) {
  const TempFolder folder;
  const std::string nifti = nifti_header({}) + bytes_of(kValues);
  expect_every_truncation_refused(folder, "a.nii", nifti);
  expect_every_truncation_refused(folder, "a.nii.gz", gzip(nifti));
  const std::string nrrd =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: ";
  expect_every_truncation_refused(folder, "a.nrrd", nrrd + "raw\n\n" + bytes_of(kValues));
  expect_every_truncation_refused(folder, "b.nrrd", nrrd + "gzip\n\n" + gzip(bytes_of(kValues)));
  const std::string meta =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n";
  expect_every_truncation_refused(folder, "a.mha", meta + bytes_of(kValues));
}

TEST(SourceVolume, DamageInAGzipStreamNeverChangesAVoxel) {
  const TempFolder folder;
  const std::string whole = gzip(nifti_header({}) + bytes_of(kValues));
  for (std::size_t at = 10; at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
    write_file(folder.file("a.nii.gz"), damaged);
    try {
      // Some bits of a stream can change without changing what it inflates to.
      EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii.gz")}, {})), bytes_of(kValues)) << at;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::source_rejected) << at;
    }
  }
}

TEST(SourceVolume, GzipOfSeveralMembersIsOneStream) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kValues);
  write_file(folder.file("a.nii.gz"), gzip(bytes.substr(0, 360)) + gzip(bytes.substr(360)));
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nii.gz")}, {})), bytes_of(kValues));
}

TEST(SourceVolume, BytesBehindTheVoxelsAreTold) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kValues) + "more";
  for (const std::string& name : {std::string("a.nii"), std::string("a.nii.gz")}) {
    write_file(folder.file(name), name.ends_with("gz") ? gzip(bytes) : bytes);
    const auto source = open_source({folder.file(name)}, {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kValues));
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "4 bytes behind"));
  }
}

TEST(SourceVolume, NrrdSpacesAreTurnedToLps) {
  const TempFolder folder;
  const std::string rest = "type: int16\ndimension: 3\nsizes: 4 3 2\nendian: big\nencoding: raw\n"
                           "space directions: (2,0,0) (0,3,0) (0,0,4)\nspace origin: (10,20,30)\n";
  for (const auto& [space, origin] :
       std::vector<std::pair<std::string, Point3>>{{"left-posterior-superior", {10, 20, 30}},
                                                   {"right-anterior-superior", {-10, -20, 30}},
                                                   {"LAS", {10, -20, 30}}}) {
    write_file(folder.file("a.nrrd"), "NRRD0004\n# a remark\nspace: " + space + "\n" + rest + "\n" +
                                          bytes_of(kValues, true));
    const auto source = open_source({folder.file("a.nrrd")}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, origin);
    EXPECT_EQ(source->description().geometry.spacing_mm, (Point3{2, 3, 4}));
    EXPECT_EQ(voxels_of(*source), bytes_of(kValues));
  }
}

TEST(SourceVolume, HeadersThatAskForTheUnreadableAreRefused) {
  const TempFolder folder;
  const std::string good =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: raw\n";
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"encoding: raw", "encoding: bzip2"},
      {"encoding: raw", "encoding: ascii"},
      {"type: short", "type: double"},
      {"sizes: 4 3 2", "sizes: 4 3"},
      {"sizes: 4 3 2", "sizes: 4 -3 2"},
      {"sizes: 4 3 2", "sizes: 4 3 9999999999"},
      {"sizes: 4 3 2", "sizes: 4 3 2\nkinds: RGB-color domain domain"},
      {"endian: little\n", ""},
      {"sizes: 4 3 2", "sizes: 4 3 2\nspace directions: none (1,0,0) (0,1,0)"},
      {"sizes: 4 3 2", "sizes: 4 3 2\nspace directions: (1,0,0) (1,0,0) (0,0,1)"},
      {"sizes: 4 3 2", "sizes: 4 3 2\nspacings: 1 2 x"},
      {"encoding: raw", "encoding: raw\ndata file: ../a.raw"},
      {"encoding: raw", "encoding: raw\ndata file: /etc/passwd"},
      {"encoding: raw", "encoding: raw\ndata file: LIST"},
      {"encoding: raw", "encoding: raw\nbyte skip: -7"}};
  for (const auto& [from, to] : changes) {
    std::string header = good;
    header.replace(header.find(from), from.size(), to);
    write_file(folder.file("a.nrrd"), header + "\n" + bytes_of(kValues));
    const ErrorKind kind = source_error({folder.file("a.nrrd")}).kind();
    EXPECT_TRUE(kind == ErrorKind::source_rejected || kind == ErrorKind::limit_exceeded) << to;
  }
}

std::string zlib_of(const std::string& bytes) {
  uLongf length = compressBound(static_cast<uLong>(bytes.size()));
  std::string out(length, '\0');
  EXPECT_EQ(
      compress(reinterpret_cast<Bytef*>(out.data()), &length,
               reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uLong>(bytes.size())),
      Z_OK);
  return out.substr(0, length);
}

TEST(SourceVolume, MetaImageInsideDetachedAndCompressed) {
  const TempFolder folder;
  const std::string header =
      "ObjectType = Image\nNDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
      "ElementSpacing = 2 3 4\nOffset = 10 20 30\nTransformMatrix = 0 1 0 -1 0 0 0 0 1\n";
  write_file(folder.file("a.mha"), header +
                                       "BinaryDataByteOrderMSB = True\nElementDataFile = LOCAL\n" +
                                       bytes_of(kValues, true));
  write_file(folder.file("b.mhd"), header + "ElementDataFile = data/b.raw\n");
  write_file(folder.file("data/b.raw"), bytes_of(kValues));
  write_file(folder.file("c.mhd"), header + "CompressedData = True\nElementDataFile = c.zraw\n");
  write_file(folder.file("c.zraw"), zlib_of(bytes_of(kValues)));
  write_file(folder.file("d.mhd"), header + "HeaderSize = -1\nElementDataFile = d.raw\n");
  write_file(folder.file("d.raw"), "some header" + bytes_of(kValues));
  for (const char* name : {"a.mha", "b.mhd", "c.mhd", "d.mhd"}) {
    const auto source = open_source({folder.file(name)}, {});
    EXPECT_EQ(source->description().geometry.origin_mm, (Point3{10, 20, 30})) << name;
    EXPECT_EQ(source->description().geometry.direction,
              (std::array<double, 9>{0, -1, 0, 1, 0, 0, 0, 0, 1}))
        << name;
    EXPECT_EQ(voxels_of(*source), bytes_of(kValues)) << name;
    EXPECT_EQ(source->resident_bytes(), 0U);
  }
}

TEST(SourceVolume, MetaImagesThatAreNoScalarVolumeAreRefused) {
  const TempFolder folder;
  const std::string good =
      "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\nElementDataFile = ";
  for (const std::string& header :
       {good + "../b.raw\n", good + "/etc/passwd\n", good + "b%03d.raw 1 2 1\n",
        good + "LIST\na\nb\n", good + "missing.raw\n",
        "ElementNumberOfChannels = 3\n" + good + "LOCAL\n",
        "BinaryData = False\n" + good + "LOCAL\n",
        std::string(
            "NDims = 3\nDimSize = 4 3 2\nElementType = MET_DOUBLE\nElementDataFile = LOCAL\n"),
        std::string(
            "NDims = 4\nDimSize = 4 3 2 2\nElementType = MET_SHORT\nElementDataFile = LOCAL\n"),
        std::string("NDims = 3\nDimSize = 4 3 2\n")}) {
    write_file(folder.file("a.mha"), header + std::string(500, '\0'));
    EXPECT_EQ(source_error({folder.file("a.mha")}).kind(), ErrorKind::source_rejected) << header;
  }
}

TEST(SourceVolume, AFolderWithOneVolumeIsThatVolume) {
  const TempFolder folder;
  write_file(folder.file("a.nii"), nifti_header({}) + bytes_of(kValues));
  EXPECT_EQ(voxels_of(*open_source({folder.path()}, {})), bytes_of(kValues));
  write_file(folder.file("b.nii"), nifti_header({}) + bytes_of(kValues));
  EXPECT_TRUE(contains(source_error({folder.path()}).what(), "2 volumes"));
}

}  // namespace
}  // namespace octavo::testing
