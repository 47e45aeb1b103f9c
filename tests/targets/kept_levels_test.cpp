// The golden files, written on another machine, give the voxels that their list names.
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "octavo/core/crc32c.h"
#include "octavo/file/reader.h"
#include "support/source_folder.h"

namespace octavo {
namespace {

const std::string kFolder = testing::source_folder() + "/tests/golden/v1/";

std::vector<std::uint8_t> level_of(const std::string& name, int level) {
  std::ifstream in(kFolder + name, std::ios::binary);
  std::vector<std::uint8_t> bytes{std::istreambuf_iterator<char>(in), {}};
  const auto reader = FileReader::open(byte_source_of(std::move(bytes), name));
  const Size3 size = reader->levels().size(level);
  std::vector<std::uint8_t> voxels(static_cast<std::size_t>(
      size.voxel_count() * bytes_per_voxel(reader->description().type)));
  reader->read(box_of(size), level, voxels.data());
  return voxels;
}

TEST(KeptFiles, GiveTheSameVoxelsOnEveryInstructionSet) {
  std::ifstream list(kFolder + "levels.txt");
  int count = 0;
  std::string name;
  int level = 0;
  std::uint32_t crc = 0;
  while (list >> name >> std::dec >> level >> std::hex >> crc) {
    EXPECT_EQ(crc32c(level_of(name, level)), crc) << name << " level " << level;
    ++count;
  }
  EXPECT_GT(count, 50);
}

}  // namespace
}  // namespace octavo
