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
