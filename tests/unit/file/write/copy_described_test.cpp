#include "octavo/file/write/copy_described.h"

#include <gtest/gtest.h>

#include <random>
#include <span>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

template <class T>
testing::Volume noisy(const Size3& size, std::int64_t noisy_width) {
  testing::Volume volume;
  volume.description.size = size;
  volume.description.type = voxel_type_of<T>();
  volume.description.metadata = Metadata::read(R"({"source":{"format":"raw"}})");
  std::mt19937 random(1);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()), T{4});
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const auto x = static_cast<std::int64_t>(i) % size.x;
    const auto y = static_cast<std::int64_t>(i) / size.x % size.y;
    if (x < noisy_width && y < noisy_width) voxels[i] = static_cast<T>(random() % 100);
  }
  const auto bytes = std::as_bytes(std::span(voxels));
  volume.voxels.assign(bytes.begin(), bytes.end());
  return volume;
}

void build(const testing::Volume& volume, double max_error, const std::string& path,
           bool has_thumbnail = false) {
  NoProgress progress;
  BuildOptions options;
  options.kind = volume.description.kind;
  options.preset = Preset::fast;
  options.max_error = max_error;
  options.has_thumbnail = has_thumbnail;
  build_file(*make_memory_source(volume.description, volume.voxels), local_storage(), path, options,
             progress);
}

std::uint64_t copy(const std::string& from, const VolumeDescription& description,
                   const std::string& to, bool overwrite = false) {
  NoProgress progress;
  return copy_described(open_byte_source(local_storage(), from), description, local_storage(), to,
                        overwrite, progress);
}

// A copy under another description has the bytes of a build under it.
void expect_copied(testing::Volume volume, double max_error, bool has_thumbnail = false) {
  const testing::ScratchFolder folder;
  build(volume, max_error, folder.file("a.8vo"), has_thumbnail);
  volume.description.geometry.origin_mm = {1, -2, 3.5};
  volume.description.geometry.direction = {0, 1, 0, 1, 0, 0, 0, 0, 1};
  volume.description.metadata.set_made_by(MadeBy("transform"));
  build(volume, max_error, folder.file("b.8vo"), has_thumbnail);
  const VolumeDescription wanted = testing::open_file(folder.file("b.8vo"))->description();
  const std::uint64_t bytes = copy(folder.file("a.8vo"), wanted, folder.file("c.8vo"));
  const std::string copied = testing::bytes_of_file(folder.file("c.8vo"));
  EXPECT_EQ(bytes, copied.size());
  EXPECT_TRUE(copied == testing::bytes_of_file(folder.file("b.8vo")));
}

TEST(CopyDescribed, GivesTheBytesOfABuildUnderThatDescription) {
  expect_copied(noisy<std::int16_t>({70, 67, 130}, 70), 0);
  expect_copied(noisy<std::int16_t>({70, 67, 65}, 70), 5);
  expect_copied(noisy<float>({70, 67, 65}, 70), 0.3);
  testing::Volume labels = noisy<std::uint8_t>({140, 67, 65}, 20);
  labels.description.kind = VolumeKind::labels;
  expect_copied(labels, 0);
}

// The axes of the copy run otherwise: its picture is another one.
TEST(CopyDescribed, MakesTheThumbnailAnew) {
  expect_copied(noisy<std::int16_t>({70, 67, 130}, 70), 0, true);
}

TEST(CopyDescribed, CopiesEveryModel) {
  // A group is 32 MiB: two of them, the second with a model of its own.
  expect_copied(noisy<std::uint8_t>({736, 736, 70}, 40), 0);
  // With a maximum error the tiers above the first have one more.
  expect_copied(noisy<std::uint8_t>({736, 736, 70}, 40), 2);
}

TEST(CopyDescribed, RejectsAnotherVolumeAndATakenNameAndLeavesNothing) {
  const testing::Volume volume = noisy<std::int16_t>({20, 20, 20}, 20);
  const testing::ScratchFolder folder;
  build(volume, 0, folder.file("a.8vo"));
  VolumeDescription other = volume.description;
  other.size.z = 21;
  EXPECT_THROW(copy(folder.file("a.8vo"), other, folder.file("b.8vo")), Error);
  other = volume.description;
  other.kind = VolumeKind::labels;
  EXPECT_THROW(copy(folder.file("a.8vo"), other, folder.file("b.8vo")), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("b.8vo")));
  EXPECT_THROW(copy(folder.file("a.8vo"), volume.description, folder.file("a.8vo")), Error);
  copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo"));
  copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo"), true);
}

TEST(CopyDescribed, RejectsADamagedBrickAndLeavesNothing) {
  const testing::Volume volume = noisy<std::int16_t>({70, 67, 65}, 70);
  const testing::ScratchFolder folder;
  build(volume, 0, folder.file("a.8vo"));
  const BrickEntry brick = testing::open_file(folder.file("a.8vo"))->brick(0, {0, 0, 0});
  std::fstream file(folder.file("a.8vo"), std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(static_cast<std::streamoff>(brick.pieces[0].offset + 5));
  file.put('\x55');
  file.put('\xaa');
  file.close();
  EXPECT_THROW(copy(folder.file("a.8vo"), volume.description, folder.file("b.8vo")), Error);
  EXPECT_FALSE(std::filesystem::exists(folder.file("b.8vo")));
  std::filesystem::remove(folder.file("a.8vo"));
  EXPECT_TRUE(folder.is_empty());
}

}  // namespace
}  // namespace octavo
