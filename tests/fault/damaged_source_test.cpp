// Sources that are cut short, and DICOM files with damage of every kind: an error that names the
// file, and never an .8vo file of what was left.
//
// Formats that only our own code reads are read here, all others by a worker process.
#include <gtest/gtest.h>

#include <filesystem>
#include <ostream>
#include <random>
#include <set>

#include "octavo/builder/builder.h"
#include "octavo/io/isolation/isolated_source.h"
#include "support/coded_dicom.h"
#include "support/dicom_samples.h"
#include "support/goal_cases.h"
#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

namespace fs = std::filesystem;

constexpr Size3 kSize{17, 13, 9};

std::vector<std::int16_t> voxels() {
  std::vector<std::int16_t> all(static_cast<std::size_t>(kSize.voxel_count()));
  std::mt19937 random(71);
  for (std::size_t i = 0; i < all.size(); ++i) {
    all[i] = static_cast<std::int16_t>(i / 7 + random() % 32);
  }
  return all;
}

IsolationOptions isolation() {
  IsolationOptions options;
  options.command = {OCTAVO_BAD_WORKER};
  options.plane_limit = std::chrono::seconds(20);
  return options;
}

// Builds `source` into `output`; what the command line does between the two.
void build_from(const std::string& path, const std::string& output) {
  SourceOptions options;
  options.spacing_mm = Point3{1, 1, 1};
  const bool is_apart = needs_isolation({path}, options);
  const auto source = is_apart ? open_isolated_source({path}, options, isolation())
                               : open_source({path}, options);
  BuildOptions how;
  how.preset = Preset::fast;
  how.threads = 1;
  NoProgress progress;
  build_file(*source, local_storage(), output, how, progress);
}

struct Sample {
  std::string name;       ///< of the file to open
  std::string shortened;  ///< of the one that is cut; empty: the same
};

void PrintTo(const Sample& sample, std::ostream* out) {
  *out << sample.name << ' ' << sample.shortened;
}

// One file of each format, in `folder`.
std::vector<Sample> write_samples(const TempFolder& folder) {
  const std::string raw = bytes_of(voxels());
  NiftiSample nifti;
  nifti.size = {17, 13, 9};
  const std::string whole = nifti_header(nifti) + raw;
  write_file(folder.file("a.nii"), whole);
  write_file(folder.file("b.nii.gz"), gzip(whole));
  const std::string meta = "NDims = 3\nDimSize = 17 13 9\nElementType = MET_SHORT\n";
  write_file(folder.file("c.mha"), meta + "ElementDataFile = LOCAL\n" + raw);
  // No line end, which a cut could take away unnoticed.
  write_file(folder.file("d.mhd"), meta + "ElementDataFile = d.raw");
  write_file(folder.file("d.raw"), raw);
  const std::string nrrd = "NRRD0004\ntype: short\ndimension: 3\nsizes: 17 13 9\nendian: little\n";
  write_file(folder.file("e.nrrd"), nrrd + "encoding: raw\n\n" + raw);
  write_file(folder.file("f.nrrd"), nrrd + "encoding: gzip\n\n" + gzip(raw));
  write_file(folder.file("o.nhdr"), nrrd + "encoding: gzip\ndata file: LIST 3\no.1\no.2\no.3");
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t part = raw.size() / 3;
    write_file(folder.file("o." + std::to_string(i + 1)), gzip(raw.substr(i * part, part)));
  }
  write_file(folder.file("g.vtk"),
             "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\n"
             "DIMENSIONS 17 13 9\nSPACING 1 1 1\nORIGIN 1 2 3\nPOINT_DATA 1989\n"
             "SCALARS s short 1\nLOOKUP_TABLE default\n" +
                 bytes_of(voxels(), true));
  std::string text;
  for (const std::int16_t voxel : voxels()) text += std::to_string(voxel) + "\n";
  write_file(folder.file("j.vtk"),
             "# vtk DataFile Version 3.0\nx\nASCII\nDATASET STRUCTURED_POINTS\n"
             "DIMENSIONS 17 13 9\nSPACING 1 1 1\nORIGIN 1 2 3\nPOINT_DATA 1989\n"
             "SCALARS s short 1\nLOOKUP_TABLE default\n" +
                 text);
  std::string gipl(256, '\0');
  gipl.replace(0, 10, bytes_of<std::uint16_t>({17, 13, 9, 1, 15}, true));
  gipl.replace(10, 16, bytes_of<float>({1, 1, 1, 1}, true));
  gipl.replace(252, 4, bytes_of<std::uint32_t>({719555000}, true));
  gipl += bytes_of(voxels(), true);
  write_file(folder.file("k.gipl"), gipl);
  write_file(folder.file("l.gipl.gz"), gzip(gipl));
  TiffSample tiff;
  tiff.width = 17;
  tiff.height = 13;
  tiff.bits = 16;
  const std::size_t plane = raw.size() / 9;
  for (std::size_t z = 0; z < 9; ++z) tiff.pages.push_back(raw.substr(z * plane, plane));
  write_tiff(folder.file("h.tif"), tiff);
  DicomSample dicom;
  dicom.columns = 17;
  dicom.rows = 13;
  dicom.position = "0\\0\\0";
  dicom.voxels = raw.substr(0, plane);
  write_dicom(folder.file("i.dcm"), dicom);
  const std::string array =
      R"({"zarr_format":3,"node_type":"array","shape":[9,13,17],"data_type":"int16",)"
      R"("chunk_grid":{"name":"regular","configuration":{"chunk_shape":[9,13,17]}},)"
      R"("fill_value":0,"codecs":[{"name":"bytes","configuration":{"endian":"little"}})";
  write_file(folder.file("m.zarr/zarr.json"), array + "]}");
  write_file(folder.file("m.zarr/c/0/0/0"), raw);
  write_file(folder.file("n.zarr/zarr.json"), array + R"(,{"name":"gzip","configuration":{}}]})");
  write_file(folder.file("n.zarr/c/0/0/0"), gzip(raw));
  return {{"m.zarr", "m.zarr/c/0/0/0"},
          {"n.zarr", "n.zarr/c/0/0/0"},
          {"m.zarr", "m.zarr/zarr.json"},
          {"a.nii", ""},      {"b.nii.gz", ""}, {"c.mha", ""},  {"d.mhd", ""},   {"d.mhd", "d.raw"},
          {"o.nhdr", ""},     {"o.nhdr", "o.2"},
          {"e.nrrd", ""},     {"f.nrrd", ""},   {"g.vtk", ""},  {"h.tif", ""},   {"i.dcm", ""},
          {"j.vtk", ""},      {"k.gipl", ""},   {"l.gipl.gz", ""}};
}

// The lengths to cut a file of `bytes` to: both ends densely, the rest evenly.
std::vector<std::size_t> lengths_of(std::size_t bytes, std::uint64_t count) {
  std::set<std::size_t> lengths;
  const std::size_t dense = std::min<std::size_t>(bytes, count / 4);
  for (std::size_t i = 0; i < dense; ++i) lengths.insert({i * 8 % bytes, bytes - 1 - i});
  const std::size_t step = std::max<std::size_t>(1, 2 * bytes / count);
  for (std::size_t at = 0; at < bytes; at += step) lengths.insert(at);
  return {lengths.begin(), lengths.end()};
}

// Cuts one file to every length; none of them may become an .8vo file.
void expect_cuts_rejected(const Sample& sample) {
  const TempFolder folder;
  write_samples(folder);
  const std::string cut = folder.file(sample.shortened.empty() ? sample.name : sample.shortened);
  const std::string path = folder.file(sample.name);
  const std::string output = folder.file("out/out.8vo");
  build_from(path, output);
  fs::remove(output);
  const std::string whole = read_file(cut);
  const auto lengths = lengths_of(whole.size(), case_count(24, 1000));
  GoalCases cases("G1", "cut files rejected", lengths.size());
  while (cases.next()) {
    const std::size_t length = lengths[cases.done() - 1];
    write_file(cut, whole.substr(0, length));
    try {
      build_from(path, output);
      ADD_FAILURE() << cut << " of " << length << " bytes became a file";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::source_rejected)
          << cut << " of " << length << " bytes: " << error.what();
      const std::string named = fs::path(error.path()).lexically_relative(folder.path());
      EXPECT_TRUE(named == sample.name || named == sample.shortened) << error.what();
    }
    ASSERT_TRUE(fs::is_empty(fs::path(output).parent_path())) << length;
  }
}

class CutSource : public ::testing::TestWithParam<Sample> {};

TEST_P(CutSource, IsRejectedAndBecomesNoFile) { expect_cuts_rejected(GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    All, CutSource, ::testing::ValuesIn(write_samples(TempFolder())), [](const auto& sample) {
      std::string name = sample.param.name + sample.param.shortened;
      for (char& c : name) c = c == '.' || c == '/' ? '_' : c;
      return name;
    });

TEST(DamagedSource, NoFlippedBitOfAGzipStreamChangesAVoxel) {
  const TempFolder folder;
  write_samples(folder);
  const std::string path = folder.file("b.nii.gz");
  const auto expected = bytes_of(voxels());
  std::string bytes = read_file(path);
  const std::uint64_t count = case_count(2000, 8 * bytes.size());
  GoalCases cases("G1", "flipped bits of a gzip stream found or without effect", count);
  std::uint64_t rejected = 0;
  while (cases.next()) {
    const std::size_t bit = (cases.done() - 1) * 8 * bytes.size() / count;
    const char kept = bytes[bit / 8];
    bytes[bit / 8] = static_cast<char>(kept ^ (1 << bit % 8));
    write_file(path, bytes);
    bytes[bit / 8] = kept;
    try {
      ASSERT_EQ(voxels_of(*open_source({path}, {})), expected) << "bit " << bit;
    } catch (const Error& error) {
      ASSERT_EQ(error.kind(), ErrorKind::source_rejected) << "bit " << bit << error.what();
      ++rejected;
    }
  }
  cases.tell(std::to_string(rejected) + " rejected");
  EXPECT_GT(rejected, cases.done() * 9 / 10);
}

// A few changes of the kinds that break readers.
std::string mutated(std::string bytes, std::mt19937_64& random) {
  for (std::uint64_t count = 1 + random() % 4; count > 0 && !bytes.empty(); --count) {
    // As often in what leads as in the picture.
    const std::size_t reach = random() % 2 == 0 ? std::min<std::size_t>(bytes.size(), 700)
                                                : bytes.size();
    const std::size_t at = random() % reach;
    const std::size_t length = std::min<std::size_t>(1 + random() % 8, bytes.size() - at);
    switch (random() % 6) {
      case 0: bytes[at] = static_cast<char>(bytes[at] ^ (1 << random() % 8)); break;
      case 1: bytes.replace(at, length, length, random() % 2 == 0 ? '\0' : '\xff'); break;
      case 2: bytes.erase(at, length); break;
      case 3: bytes.insert(at, bytes.substr(random() % bytes.size(), length)); break;
      case 4: bytes[at] = static_cast<char>(random()); break;
      default:
        if (random() % 4 == 0) bytes.resize(at);
    }
  }
  return bytes;
}

TEST(DamagedSource, MutatedDicomFilesAreVoxelsOrErrors) {
  using Syntax = gdcm::TransferSyntax;
  const TempFolder folder;
  const std::string path = folder.file("mutated.dcm");
  std::vector<std::string> whole;
  DicomSample sample;
  sample.position = "0\\0\\0";
  for (const auto syntax : {Syntax::RLELossless, Syntax::JPEGLosslessProcess14_1,
                            Syntax::JPEG2000Lossless, Syntax::JPEGLSLossless}) {
    whole.push_back(coded_slice(folder, sample, syntax));
  }
  GoalCases cases("G2", "mutated DICOM files survived", case_count(60, 10'000));
  std::uint64_t read = 0;
  std::uint64_t crashes = 0;
  std::mt19937_64 random(72);
  while (cases.next()) {
    write_file(path, mutated(whole[cases.done() % whole.size()], random));
    const std::string output = folder.file("out/out.8vo");
    try {
      build_from(path, output);
      ++read;
      fs::remove(output);
    } catch (const Error& error) {
      const std::string message = error.what();
      ASSERT_EQ(error.kind(), ErrorKind::source_rejected) << cases.done() << ": " << message;
      ASSERT_EQ(error.path(), path) << message;
      if (message.find("signal") != std::string::npos) ++crashes;
    }
    ASSERT_TRUE(fs::is_empty(folder.file("out")));
  }
  cases.tell(std::to_string(read) + " read, " + std::to_string(crashes) +
             " ended a worker, all others rejected");
  EXPECT_GT(read, 0u);
  EXPECT_LT(read, cases.done());
}

}  // namespace
}  // namespace octavo::testing
