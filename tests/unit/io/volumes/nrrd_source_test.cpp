#include "octavo/io/volumes/nrrd_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(NrrdSource, HeadersThatAskForTheUnreadableAreRejected) {
  const TempFolder folder;
  const std::string good =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: raw\n";
  const std::vector<std::pair<std::string, std::string>> changes = {
      {"encoding: raw", "encoding: bzip2"},
      {"encoding: raw", "encoding: ascii"},
      {"type: short", "type: block"},
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
    write_file(folder.file("a.nrrd"), header + "\n" + bytes_of(kStoredValues));
    const ErrorKind kind = source_error({folder.file("a.nrrd")}).kind();
    EXPECT_TRUE(kind == ErrorKind::source_rejected || kind == ErrorKind::limit_exceeded) << to;
  }
}

TEST(NrrdSource, BytesStandInOneOfTwoOrders) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto first_byte = [&](const std::string& endian) {
    write_file(path, "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nencoding: raw\n"
                     "spacings: 1 1 1\nendian: " + endian + "\n\n" +
                         bytes_of(std::vector<std::int16_t>(24, 7), false));
    return voxels_of(*open_source({path}, {}))[0];
  };
  EXPECT_EQ(first_byte("little"), '\7');
  EXPECT_EQ(first_byte("Little"), '\7');
  EXPECT_EQ(first_byte("BIG"), '\0');
  for (const char* endian : {"bigg", "1"}) {
    EXPECT_THROW(first_byte(endian), Error);
    expect_rejected(path, {std::string("endian is \"") + endian + "\"", "little or big expected"});
  }
}

TEST(NrrdSource, FieldsThatAreThereTwiceAreRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto write = [&](const std::string& more) {
    write_file(path, "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\n"
                     "encoding: raw\nspacings: 1 1 1\n# a\n# a\n" + more + "\n" +
                         bytes_of(kStoredValues));
  };
  write("a:=1\nb:=2\n");
  EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues));
  for (const char* name : {"type", "endian", "spacings", "Sizes"}) {
    write(name + std::string(": short\n"));
    expect_rejected(path, {"the header has the field", "twice"});
  }
  write("byte skip: 0\nbyteskip: 1\n");
  expect_rejected(path, {"the header has the field \"byte skip\" twice"});
}

const std::string kSeveralFiles =
    "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nspacings: 1 1 1\nendian: little\n";

TEST(NrrdSource, VoxelsMayStandInSeveralFiles) {
  struct Case {
    std::size_t files;
    std::string fields;
    bool is_gzip = false;
    std::string front = {};
  };
  for (const Case& one : std::vector<Case>{
           {2, "encoding: raw\ndata file: LIST\np1.raw\np2.raw\n"},
           {2, "encoding: raw\ndata file: LIST 2\r\np1.raw\r\np2.raw"},
           {6, "encoding: raw\ndata file: LIST 1\np1.raw\np2.raw\np3.raw\np4.raw\np5.raw\n"
               "p6.raw\n"},
           {1, "encoding: raw\ndata file: LIST 3\np1.raw\n"},
           {2, "encoding: raw\ndata file: LIST 3\np1.raw\np2.raw\n"},
           {2, "encoding: raw\ndata file: LIST 2D\np1.raw\np2.raw\n"},
           {2, "encoding: raw\ndata file: p%d.raw 1 2 1\n"},
           {2, "encoding: raw\nline skip: 2\ndata file: p%d.raw 1 2 1\n", false, "a\nbc\r\n"},
           {2, "encoding: raw\nline skip: 1\nbyte skip: 2\ndata file: p%d.raw 1 2 1\n", false,
            "a\nbc"},
           {2, "encoding: raw\nlineskip: 1\nbyte skip: -1\ndata file: p%d.raw 1 2 1\n", false,
            "ab"},
           {2, "data file: p%01d.raw 1 2 1 2\nencoding: raw\n"},
           {6, "encoding: raw\ndatafile: p%d.raw 1 6 1 1\n"},
           {2, "encoding: gzip\ndata file: p%d.raw 1 2 1\n", true},
           {2, "encoding: gzip\nbyte skip: 3\ndata file: p%d.raw 1 2 1\n", true, "abc"},
           {2, "encoding: raw\nbyte skip: 3\ndata file: p%d.raw 1 2 1\n", false, "abc"},
           {2, "encoding: raw\nbyte skip: -1\ndata file: LIST\np1.raw\np2.raw\n", false, "ab"}}) {
    const TempFolder folder;
    write_parts(folder, one.files, [&](const std::string& part) {
      return one.is_gzip ? gzip(one.front + part) : one.front + part;
    });
    write_file(folder.file("a.nhdr"), kSeveralFiles + one.fields);
    const auto source = open_source({folder.file("a.nhdr")}, {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues)) << one.fields;
    EXPECT_EQ(source->files().paths.size(), one.files + 1);
    EXPECT_TRUE(contains(source->description().metadata.text(),
                         "\"files\":" + std::to_string(one.files + 1)))
        << source->description().metadata.text();
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
  }
}

TEST(NrrdSource, LinesAreSkippedInFrontOfTheDataOrOfItsCompression) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const std::string voxels = bytes_of(kStoredValues);
  for (const auto& [encoding, data] : std::vector<std::pair<std::string, std::string>>{
           {"raw\nline skip: 1", "one\n" + voxels}, {"gzip\nline skip: 1", "\n" + gzip(voxels)},
           {"gzip\nline skip: 1\nbyte skip: 2", "one\n" + gzip("ab" + voxels)},
           {"raw\nline skip: 0", voxels}}) {
    write_file(path, kSeveralFiles + "encoding: " + encoding + "\n\n" + data);
    const auto source = open_source({path}, {});
    EXPECT_EQ(voxels_of(*source), voxels) << encoding;
    EXPECT_TRUE(source->warnings().empty()) << with_hints(source->warnings());
  }
  write_file(path, kSeveralFiles + "encoding: raw\nline skip: 3\n\none\ntwo\n");
  expect_rejected(path, {"line skip: 3 lines expected, 2 found"});
  write_file(path, kSeveralFiles + "encoding: raw\nline skip: -1\n\n" + voxels);
  expect_rejected(path, {"line skip is -1"});
}

TEST(NrrdSource, HeadersOfUnknownVersionsAndSizesBelow1AreRejected) {
  const TempFolder folder;
  const std::string path = folder.file("a.nrrd");
  const auto write = [&](const std::string& magic, const std::string& sizes) {
    write_file(path, magic + "\ntype: uchar\ndimension: 3\nsizes: " + sizes +
                         "\nspacings: 1 1 1\nencoding: raw\n\n" + std::string(24, '\1'));
  };
  for (const char* magic : {"NRRD0001", "NRRD0004\r", "NRRD0005", "NRRD0006"}) {
    write(magic, "4 3 2");
    EXPECT_EQ(voxels_of(*open_source({path}, {})).size(), 24U) << magic;
  }
  for (const char* magic : {"NRRD0000", "NRRD0007", "NRRD0009", "NRRD00011"}) {
    write(magic, "4 3 2");
    expect_rejected(path, {"NRRD0001 to NRRD0006"});
  }
  for (const char* sizes : {"4 -3 2", "4 3 0"}) {
    write("NRRD0005", sizes);
    expect_rejected(path, {"sizes", "numbers from 1 on expected"});
  }
}

TEST(NrrdSource, BlanksMayStandInNamesOfFiles) {
  const TempFolder folder;
  const std::string voxels = bytes_of(kStoredValues);
  write_file(folder.file("my  run 2/p 1.raw"), voxels.substr(0, 24));
  write_file(folder.file("my  run 2/p 2.raw"), voxels.substr(24));
  const std::string path = folder.file("a.nhdr");
  for (const char* names :
       {"my  run 2/p %d.raw 1 2 1", "my  run 2/p %d.raw 1 2 1 2",
        "LIST\nmy  run 2/p 1.raw\nmy  run 2/p 2.raw"}) {
    write_file(path, kSeveralFiles + "encoding: raw\ndata file: " + names + "\n");
    EXPECT_EQ(voxels_of(*open_source({path}, {})), voxels) << names;
  }
  write_file(folder.file("a.mhd"), "NDims = 3\nDimSize = 4 3 2\nElementType = MET_SHORT\n"
                                   "ElementDataFile = my  run 2/p %d.raw 1 2 1\n");
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.mhd")}, {})), voxels);
}

TEST(NrrdSource, ThePatternOfFilesFallsWhereItsNumbersDo) {
  const TempFolder folder;
  write_parts(folder, 2);
  write_file(folder.file("a.nhdr"), kSeveralFiles + "encoding: raw\ndata file: p%d.raw 2 1 -1\n");
  const std::string all = bytes_of(kStoredValues);
  EXPECT_EQ(voxels_of(*open_source({folder.file("a.nhdr")}, {})),
            all.substr(24) + all.substr(0, 24));
}

TEST(NrrdSource, TimesAndChannelsMayStandInSeveralFiles) {
  const TempFolder folder;
  write_parts(folder, 2);
  const std::string path = folder.file("a.nhdr");
  write_file(path, "NRRD0004\ntype: short\ndimension: 4\nsizes: 4 3 1 2\nendian: little\n"
                   "kinds: domain domain domain time\nspacings: 1 1 1 nan\nencoding: raw\n"
                   "data file: LIST\np1.raw\np2.raw\n");
  SourceOptions options;
  for (const std::int64_t time : {0, 1}) {
    options.time = time;
    EXPECT_EQ(voxels_of(*open_source({path}, options)),
              bytes_of(kStoredValues).substr(static_cast<std::size_t>(time) * 24, 24));
  }
}

TEST(NrrdSource, AHeaderMayHaveAMebibyte) {
  constexpr std::size_t kMost = std::size_t{1} << 20;
  const TempFolder folder;
  write_parts(folder, 2);
  const std::string path = folder.file("a.nhdr");
  const std::string list = kSeveralFiles + "encoding: raw\ndata file: LIST\np1.raw\np2.raw";
  write_file(path, list + std::string(kMost - list.size(), '\n'));
  EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues));
  write_file(path, list + std::string(kMost - list.size() + 1, '\n'));
  expect_rejected(path, {"the list of data files exceeds 1 MiB"});
  const std::string plain = kSeveralFiles + "encoding: raw\ndata file: p%d.raw 1 2 1\n#";
  write_file(path, plain + std::string(kMost - plain.size(), 'c'));
  EXPECT_EQ(voxels_of(*open_source({path}, {})), bytes_of(kStoredValues));
  write_file(path, plain + std::string(kMost - plain.size() + 1, 'c'));
  expect_rejected(path, {"the NRRD header exceeds 1 MiB"});
}

TEST(NrrdSource, FilesThatDoNotFitTheirHeaderAreNamed) {
  const TempFolder folder;
  write_parts(folder, 2);
  const std::string path = folder.file("a.nhdr");
  const auto expect = [&](const std::string& fields, const std::string& words) {
    write_file(path, kSeveralFiles + fields);
    expect_rejected(path, {words});
  };
  const std::string raw = "encoding: raw\n";
  expect(raw + "data file: LIST\np1.raw\n", "names 1 data file, 2 expected");
  expect(raw + "data file: LIST\np1.raw\np2.raw\np2.raw\n", "names 3 data files, 2 expected");
  expect(raw + "data file: LIST\np1.raw\np3.raw\n", "\"p3.raw\" is missing");
  expect(raw + "data file: LIST\np1.raw\n../p2.raw\n", "\"../p2.raw\" is not beneath");
  expect(raw + "data file: LIST\np1.raw\n/etc/passwd\n", "\"/etc/passwd\" is not beneath");
  expect(raw + "data file: LIST 9\np1.raw\np2.raw\n", "9 dimensions, 1 to 3 expected");
  expect(raw + "data file: p%d.raw 1 3 1\n", "names 3 data files, 2 expected");
  expect(raw + "data file: p%d.raw 0 1 1\n", "\"p0.raw\" is missing");
  expect(raw + "data file: p%d.raw 1 2 0\n", "names 0 data files");
  expect(raw + "data file: p%d.raw 1 x 1\n", "x");
  expect(raw + "data file: p%s.raw 1 2 1\n", "is missing");
  write_file(folder.file("p2.raw"), std::string(23, 'x'));
  expect(raw + "data file: p%d.raw 1 2 1\n", "24 bytes needed for one of 2 parts");
  expect(raw + "byte skip: -1\ndata file: p%d.raw 1 2 1\n", "24 bytes of voxels expected");
  write_file(folder.file("p2.raw"), std::string(30, 'x'));
  write_file(path, kSeveralFiles + raw + "data file: p%d.raw 1 2 1\n");
  EXPECT_TRUE(contains(first_warning(*open_source({path}, {})), "6 bytes behind the voxels"));
}

TEST(NrrdSource, EveryTruncationIsRejected) {
  const TempFolder folder;
  const std::string header =
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 3 2\nendian: little\nencoding: ";
  expect_every_truncation_rejected(folder.file("a.nrrd"),
                                   header + "raw\n\n" + bytes_of(kStoredValues));
  expect_every_truncation_rejected(folder.file("b.nrrd"),
                                   header + "gzip\n\n" + gzip(bytes_of(kStoredValues)));
}

}  // namespace
}  // namespace octavo::testing
