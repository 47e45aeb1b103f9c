#include "octavo/io/source/streamed_source.h"

#include <gtest/gtest.h>

#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(StreamedSource, BytesBehindTheVoxelsAreReported) {
  const TempFolder folder;
  const std::string bytes = nifti_header({}) + bytes_of(kStoredValues) + "more";
  for (const std::string& name : {std::string("a.nii"), std::string("a.nii.gz")}) {
    write_file(folder.file(name), name.ends_with("gz") ? gzip(bytes) : bytes);
    const auto source = open_source({folder.file(name)}, {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues));
    ASSERT_EQ(source->warnings().size(), 1U);
    EXPECT_TRUE(contains(source->warnings()[0], "4 bytes behind"));
  }
}

/// A MetaImage of 4 x 3 x 2 voxels.
std::string write_header(const TempFolder& folder, const std::string& fields) {
  std::string path = folder.file("a.mhd");
  write_file(path, "NDims = 3\nDimSize = 4 3 2\nElementSpacing = 1 1 1\n" + fields);
  return path;
}

TEST(StreamedSource, FilesWithBytesBehindTheirVoxelsAreNamed) {
  const auto warning_of = [](bool is_zlib, const std::vector<std::string>& behind) {
    const TempFolder folder;
    std::size_t part = 0;
    write_parts(folder, behind.size(), [&](const std::string& bytes) {
      const std::string all = bytes + behind[part++];
      return is_zlib ? zlib_stream(all) : all;
    });
    const auto source = open_source(
        {write_header(folder, std::string("ElementType = MET_SHORT\n") +
                                  (is_zlib ? "CompressedData = True\n" : "") +
                                  "ElementDataFile = p%d.raw 1 2 1\n")},
        {});
    EXPECT_EQ(voxels_of(*source), bytes_of(kStoredValues));
    const std::string warning = first_warning(*source);
    return warning.substr(0, warning.find(folder.path())) +
           warning.substr(std::min(warning.rfind('/'), warning.size()));
  };
  for (const bool is_zlib : {false, true}) {
    EXPECT_EQ(warning_of(is_zlib, {"abc", ""}),
              "3 bytes behind the voxels were left out: /p1.raw");
    EXPECT_EQ(warning_of(is_zlib, {"", "abc"}),
              "3 bytes behind the voxels were left out: /p2.raw");
    EXPECT_EQ(warning_of(is_zlib, {"a", "bc"}),
              "3 bytes behind the voxels were left out: /p1.raw and 1 other file");
  }
}

TEST(StreamedSource, ValuesThatNothingHoldsAreFoundInTheirFile) {
  constexpr std::size_t kValues = 24;
  for (const std::size_t files : {1U, 2U, 6U}) {
    for (const std::size_t bad : {0U, 5U, 11U, 23U}) {
      const TempFolder folder;
      std::vector<std::int64_t> values(kValues, 1);
      values[bad] = std::int64_t{1} << 40;
      const std::size_t part = kValues / files;
      std::string list;
      for (std::size_t i = 0; i < files; ++i) {
        const std::string name = "p" + std::to_string(i) + ".raw";
        write_file(folder.file(name), bytes_of(values).substr(i * part * 8, part * 8));
        list += name + "\n";
      }
      const std::string dimension = std::to_string(files == 1 ? 3 : files == 2 ? 2 : 1);
      const Error error = source_error({write_header(
          folder, "ElementType = MET_LONG_LONG\nElementDataFile = LIST " + dimension + "\n" +
                      list)});
      EXPECT_TRUE(contains(error, "the value 1099511627776 at")) << error.what();
      EXPECT_EQ(error.path(), folder.file("p" + std::to_string(bad / part) + ".raw"));
    }
  }
}

}  // namespace
}  // namespace octavo::testing
