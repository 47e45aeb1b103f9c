#include "octavo/io/images/png_source.h"

#include <gtest/gtest.h>

#include "support/image_samples.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

TEST(PngSource, GivesTheStoredVoxels) {
  const TempFolder folder;
  const std::vector<std::uint16_t> values = {0, 1, 256, 65535, 7, 40000};
  write_png(folder.file("p10.png"), 3, 2, 16, 0, bytes_of(values, true));
  write_png(folder.file("p9.png"), 3, 2, 16, 0, std::string(12, '\1'));
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(source->description().type, VoxelType::uint16);
  EXPECT_EQ(voxels_of(*source), std::string(12, '\1') + bytes_of(values));
}

/// A row of 8 grey levels, 0 or the largest one, in so many bits.
std::string black_and_white(int bits) {
  std::string row;
  for (int byte = 0; byte < bits; ++byte) row += static_cast<char>(bits == 1 ? 0x0f : 0);
  for (int byte = bits / 2; bits > 1 && byte < bits; ++byte) {
    row[static_cast<std::size_t>(byte)] = static_cast<char>(0xff);
  }
  return row;
}

TEST(PngSource, PlanesOfSeveralDepthsAreScaledToOne) {
  const TempFolder folder;
  std::string expected;
  for (const int bits : {8, 1, 2, 4, 8}) {
    const std::string name = "p" + std::to_string(expected.size() / 8) + ".png";
    write_png(folder.file(name), 8, 1, bits, 0, black_and_white(bits));
    expected += std::string(4, '\0') + std::string(4, '\xff');
  }
  const auto source = open_source({folder.path()}, {});
  EXPECT_EQ(voxels_of(*source), expected);
  EXPECT_TRUE(contains(source->warnings()[0], "1, 2, 4 and 8 bits")) << source->warnings()[0];
}

TEST(PngSource, PlanesOfOneSmallDepthKeepTheirNumbers) {
  for (const auto& [bits, white] : {std::pair{1, 1}, {2, 3}, {4, 15}}) {
    const TempFolder folder;
    for (const char* name : {"p0.png", "p1.png"}) {
      write_png(folder.file(name), 8, 1, bits, 0, black_and_white(bits));
    }
    const auto source = open_source({folder.path()}, {});
    const std::string plane = std::string(4, '\0') + std::string(4, static_cast<char>(white));
    EXPECT_EQ(voxels_of(*source), plane + plane);
    EXPECT_TRUE(contains(source->warnings()[0], "0 to " + std::to_string(white)));
  }
}

TEST(PngSource, PicturesThatAreNoStackAreRejected) {
  const TempFolder folder;
  write_png(folder.file("a1.png"), 3, 2, 8, 0, counted(6, 0));
  write_png(folder.file("a2.png"), 2, 2, 8, 0, counted(4, 0));
  EXPECT_TRUE(contains(source_error({folder.path()}), "2 x 2"));
  write_png(folder.file("rgb.png"), 2, 2, 8, 2, counted(12, 0));
  EXPECT_TRUE(contains(source_error({folder.file("rgb.png")}), "3 channels"));
  const std::string whole = read_file(folder.file("a1.png"));
  for (std::size_t length = 8; length < whole.size(); ++length) {
    write_file(folder.file("cut.png"), whole.substr(0, length));
    EXPECT_EQ(source_error({folder.file("cut.png")}).kind(), ErrorKind::source_rejected) << length;
  }
}

}  // namespace
}  // namespace octavo::testing
