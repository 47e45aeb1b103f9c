#include "octavo/planes/memory_source.h"

#include <gtest/gtest.h>

#include "octavo/core/error.h"
#include "support/sought_planes.h"

namespace octavo {
namespace {

VolumeDescription description_of(const Size3& size) {
  VolumeDescription description;
  description.type = VoxelType::int16;
  description.size = size;
  return description;
}

TEST(MemorySource, PlanesComeInOrderAndEnd) {
  std::vector<std::byte> voxels;
  for (int i = 0; i < 24; ++i) voxels.push_back(static_cast<std::byte>(i));
  const auto source = make_memory_source(description_of({2, 2, 3}), voxels);
  EXPECT_EQ(source->resident_bytes(), 24u);
  std::vector<std::byte> all;
  std::vector<std::byte> plane(8);
  for (int z = 0; z < 3; ++z) {
    source->read_plane(plane);
    all.insert(all.end(), plane.begin(), plane.end());
  }
  EXPECT_EQ(all, voxels);
  EXPECT_THROW(source->read_plane(plane), Error);
}

TEST(MemorySource, PlanesAreTheSameFromAnywhere) {
  std::vector<std::byte> voxels;
  for (int i = 0; i < 80; ++i) voxels.push_back(static_cast<std::byte>(i));
  testing::expect_same_from_anywhere(*make_memory_source(description_of({2, 2, 10}), voxels));
}

TEST(MemorySource, BytesThatAreNotThoseOfTheDescriptionAreRejected) {
  const std::vector<std::byte> voxels(24);
  EXPECT_THROW(make_memory_source(description_of({2, 2, 2}), voxels), Error);
  EXPECT_THROW(make_memory_source(description_of({2, 2, 4}), voxels), Error);
  EXPECT_THROW(make_memory_source(description_of({0, 2, 3}), voxels), Error);
}

}  // namespace
}  // namespace octavo
