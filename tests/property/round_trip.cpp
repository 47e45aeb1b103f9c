#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <limits>

#include "octavo/core/levels.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using octavo::testing::ScratchFolder;
using octavo::testing::Volume;

constexpr VoxelType kGreyTypes[] = {VoxelType::int8,   VoxelType::uint8, VoxelType::int16,
                                    VoxelType::uint16, VoxelType::int32, VoxelType::uint32};
constexpr VoxelType kLabelTypes[] = {VoxelType::uint8, VoxelType::uint16, VoxelType::uint32};

// How the values of a volume spread.
enum class Texture { constant, few_values, smooth, noisy, full_range, count };

std::uint64_t next_random(std::uint64_t& state) {
  state = state * 6364136223846793005u + 1442695040888963407u;
  return state >> 33 ^ state >> 11;
}

template <class T>
T voxel_value(Texture texture, const Index3& p, std::uint64_t& state) {
  const std::uint64_t random = next_random(state);
  switch (texture) {
    case Texture::constant: return std::numeric_limits<T>::max();
    case Texture::few_values: return static_cast<T>(random % 3 == 0 ? p.z / 5 % 4 : 2);
    case Texture::smooth: return static_cast<T>((p.x * 3 + p.y * 2 + p.z) / 4 + 5);
    case Texture::noisy:
      return static_cast<T>(40 + (p.x + p.y) / 8 + static_cast<int>(random % 15));
    default: return static_cast<T>(random);
  }
}

Volume make_volume(VolumeKind kind, VoxelType type, const Size3& size, Texture texture,
                   std::uint64_t seed) {
  Volume volume;
  volume.description.kind = kind;
  volume.description.type = type;
  volume.description.size = size;
  with_voxel_type(type, [&](auto id) {
    using T = typename decltype(id)::type;
    std::vector<T> voxels;
    voxels.reserve(static_cast<std::size_t>(size.voxel_count()));
    for (std::int64_t z = 0; z < size.z; ++z)
      for (std::int64_t y = 0; y < size.y; ++y)
        for (std::int64_t x = 0; x < size.x; ++x)
          voxels.push_back(voxel_value<T>(texture, {x, y, z}, seed));
    const auto bytes = std::as_bytes(std::span(voxels));
    volume.voxels.assign(bytes.begin(), bytes.end());
  });
  return volume;
}

void expect_round_trip(const Volume& volume, const ScratchFolder& folder) {
  const std::string path = folder.file("volume.8vo");
  build_volume(volume, path, 2);
  const auto reader = octavo::testing::open_file(path);
  const VolumeDescription& found = reader->description();
  EXPECT_EQ(found.kind, volume.description.kind);
  EXPECT_EQ(found.type, volume.description.type);
  EXPECT_EQ(found.size, volume.description.size);
  EXPECT_EQ(found.geometry, volume.description.geometry);
  EXPECT_TRUE(octavo::testing::read_box(*reader, box_of(found.size), 0) == volume.voxels);
  std::filesystem::remove(path);
}

std::string describe(const Volume& volume) {
  const Size3& size = volume.description.size;
  return std::string(voxel_type_name(volume.description.type)) + " " + std::to_string(size.x) +
         "x" + std::to_string(size.y) + "x" + std::to_string(size.z);
}

TEST(RoundTrip, EveryVoxelComesBackForAwkwardSizesAndAllTypes) {
  const ScratchFolder folder;
  const Size3 sizes[] = {{1, 1, 1},    {1, 7, 1},    {1, 1, 131},  {2, 1, 1},   {2, 3, 5},
                         {67, 61, 71}, {65, 65, 65}, {64, 64, 64}, {129, 2, 3}, {3000, 2, 2}};
  std::uint64_t seed = 1;
  for (const Size3& size : sizes) {
    for (const VoxelType type : kGreyTypes) {
      const Volume volume =
          make_volume(VolumeKind::grey, type, size, static_cast<Texture>(seed % 5), seed);
      ++seed;
      SCOPED_TRACE("grey " + describe(volume));
      expect_round_trip(volume, folder);
    }
    for (const VoxelType type : kLabelTypes) {
      const Volume volume =
          make_volume(VolumeKind::labels, type, size, static_cast<Texture>(seed % 3), seed);
      ++seed;
      SCOPED_TRACE("labels " + describe(volume));
      expect_round_trip(volume, folder);
    }
  }
}

TEST(RoundTrip, ThickSlicesComeBack) {
  const ScratchFolder folder;
  Volume volume = make_volume(VolumeKind::grey, VoxelType::int16, {90, 70, 23}, Texture::noisy, 5);
  volume.description.geometry.spacing_mm = {0.7, 0.7, 5.0};
  expect_round_trip(volume, folder);
}

Volume any_volume() {
  const bool is_grey = *rc::gen::arbitrary<bool>();
  const VoxelType type = is_grey ? *rc::gen::elementOf(std::vector<VoxelType>(
                                       std::begin(kGreyTypes), std::end(kGreyTypes)))
                                 : *rc::gen::elementOf(std::vector<VoxelType>(
                                       std::begin(kLabelTypes), std::end(kLabelTypes)));
  const auto axis = rc::gen::inRange<std::int64_t>(1, 90);
  const Size3 size{*axis, *axis, *axis};
  const auto texture = static_cast<Texture>(*rc::gen::inRange(0, static_cast<int>(Texture::count)));
  const auto seed = *rc::gen::arbitrary<std::uint64_t>();
  return make_volume(is_grey ? VolumeKind::grey : VolumeKind::labels, type, size, texture, seed);
}

Box any_box(const Size3& size) {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    box.lo[axis] = *rc::gen::inRange<std::int64_t>(0, size[axis]);
    box.hi[axis] = *rc::gen::inRange<std::int64_t>(box.lo[axis], size[axis]) + 1;
  }
  return box;
}

RC_GTEST_PROP(RoundTripProperty, AnyBoxAtAnyLevelEqualsTheCrop, ()) {
  const ScratchFolder folder;
  const Volume volume = any_volume();
  const std::string path = folder.file("volume.8vo");
  build_volume(volume, path, *rc::gen::inRange(1, 4));
  const auto reader = octavo::testing::open_file(path);
  const std::int64_t width = bytes_per_voxel(volume.description.type);
  for (int level = 0; level < reader->levels().count(); ++level) {
    const Size3& size = reader->levels().size(level);
    const auto whole = octavo::testing::read_box(*reader, box_of(size), level);
    if (level == 0) RC_ASSERT(whole == volume.voxels);
    const Box box = any_box(size);
    RC_ASSERT(octavo::testing::read_box(*reader, box, level) ==
              octavo::testing::crop(whole, size, width, box));
  }
}

RC_GTEST_PROP(RoundTripProperty, FileDoesNotDependOnThreads, ()) {
  const ScratchFolder folder;
  const Volume volume = any_volume();
  build_volume(volume, folder.file("one"), 1);
  build_volume(volume, folder.file("more"), *rc::gen::inRange(2, 9));
  RC_ASSERT(octavo::testing::bytes_of_file(folder.file("one")) ==
            octavo::testing::bytes_of_file(folder.file("more")));
}

}  // namespace
}  // namespace octavo
