#include "octavo/builder/flat_cubes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <span>

#include "octavo/core/error.h"
#include "octavo/octree/o_code.h"
#include "support/built_file.h"
#include "support/sought_planes.h"

namespace octavo {
namespace {

using testing::ScratchFolder;
using testing::Volume;

struct DenseVolume {
  Size3 size;
  std::vector<std::int64_t> voxels;  ///< [z][y][x]
};

struct Scene {
  Size3 size;
  VoxelType type;
  Point3 spacing{1, 1, 1};
  int noise;        ///< everywhere
  int texture;      ///< in a part of the volume
};

/// A gentle slope with noise, and a part where neighbors differ strongly.
DenseVolume dense_volume(const Scene& scene) {
  std::mt19937 random(5);
  const auto draw = [&](int most) {
    return most > 0 ? static_cast<std::int64_t>(random() % static_cast<unsigned>(most + 1)) : 0;
  };
  DenseVolume dense{scene.size, {}};
  for (std::int64_t i = 0; i < scene.size.voxel_count(); ++i) {
    const std::int64_t x = i % scene.size.x;
    const std::int64_t z = i / (scene.size.x * scene.size.y);
    const bool is_rough = x < scene.size.x / 3 && z < scene.size.z / 2;
    dense.voxels.push_back(20 + x / 40 + draw(scene.noise) + (is_rough ? draw(scene.texture) : 0));
  }
  return dense;
}

std::shared_ptr<FileReader> file_of(const ScratchFolder& folder, const Scene& scene,
                                    const DenseVolume& dense, double max_error = 0) {
  Volume volume;
  volume.description.type = scene.type;
  volume.description.size = scene.size;
  volume.description.geometry.spacing_mm = scene.spacing;
  const auto width = static_cast<std::size_t>(bytes_per_voxel(scene.type));
  volume.voxels.resize(dense.voxels.size() * width);
  with_voxel_type(scene.type, [&](auto id) {
    for (std::size_t i = 0; i < dense.voxels.size(); ++i) {
      const auto value = static_cast<typename decltype(id)::type>(dense.voxels[i]);
      std::memcpy(volume.voxels.data() + i * width, &value, width);
    }
  });
  const auto source = make_memory_source(volume.description, volume.voxels);
  NoProgress progress;
  BuildOptions options;
  options.preset = Preset::fast;
  options.max_error = max_error;
  build_file(*source, local_storage(), folder.file("v.8vo"), options, progress);
  return testing::open_file(folder.file("v.8vo"));
}

std::vector<std::int64_t> values_of(const std::vector<std::byte>& bytes, VoxelType type) {
  std::vector<std::int64_t> values;
  with_voxel_type(type, [&](auto id) {
    typename decltype(id)::type value;
    for (std::size_t i = 0; i < bytes.size(); i += sizeof value) {
      std::memcpy(&value, bytes.data() + i, sizeof value);
      values.push_back(static_cast<std::int64_t>(value));
    }
  });
  return values;
}

std::vector<std::int64_t> planes_of(PlaneSource& source) {
  const VolumeDescription& d = source.description();
  std::vector<std::byte> plane(
      static_cast<std::size_t>(d.size.x * d.size.y * bytes_per_voxel(d.type)));
  std::vector<std::byte> all;
  for (std::int64_t z = 0; z < d.size.z; ++z) {
    source.read_plane(plane);
    all.insert(all.end(), plane.begin(), plane.end());
  }
  return values_of(all, d.type);
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = {
      {{1, 1, 1}, VoxelType::uint8, {1, 1, 1}, 0, 0},
      {{7, 5, 9}, VoxelType::int16, {1, 1, 1}, 3, 9},
      {{67, 34, 130}, VoxelType::uint16, {1, 1, 1}, 2, 30},
      {{130, 128, 128}, VoxelType::uint8, {1, 1, 1}, 1, 0},
      {{70, 66, 40}, VoxelType::int32, {0.5, 0.5, 2}, 1, 40},
  };
  return all;
}

/// Every cube from the root down that is flat as far as the volume goes, by its definition.
DenseVolume evened_out(const DenseVolume& dense, std::int64_t flat) {
  DenseVolume result = dense;
  const auto at = [&](const Index3& p) {
    return static_cast<std::size_t>((p.z * dense.size.y + p.y) * dense.size.x + p.x);
  };
  const auto visit = [&](const auto& self, const OCode& cube) -> void {
    const Box box = intersection(box_of(dense.size), box_of(cube));
    if (box.is_empty()) return;
    std::vector<std::size_t> places;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) places.push_back(at({x, y, z}));
      }
    }
    std::int64_t min = dense.voxels[places[0]], max = min, sum = 0;
    for (const std::size_t i : places) {
      min = std::min(min, dense.voxels[i]);
      max = std::max(max, dense.voxels[i]);
      sum += dense.voxels[i];
    }
    if (max - min <= flat) {
      const double mean = static_cast<double>(sum) / static_cast<double>(places.size());
      for (const std::size_t i : places) {
        result.voxels[i] = static_cast<std::int64_t>(std::floor(mean + 0.5));
      }
    } else {
      for (const OCode& child : children_of(cube)) self(self, child);
    }
  };
  visit(visit, {universe_level(dense.size), 0});
  return result;
}

TEST(FlatCubes, AtTheBorderTheyAreEvenedOutAsFarAsTheVolumeGoes) {
  // As in a single slice, a thin stack, odd sides, and blocks of 64^3 with others outside.
  const Scene thin[] = {{{90, 70, 1}, VoxelType::uint8, {1, 1, 1}, 3, 30},
                        {{33, 20, 3}, VoxelType::int16, {1, 1, 1}, 2, 9},
                        {{2, 2, 3}, VoxelType::uint8, {1, 1, 1}, 90, 0},
                        {{200, 65, 70}, VoxelType::uint8, {1, 1, 1}, 1, 5}};
  for (const Scene& scene : thin) {
    const DenseVolume dense = dense_volume(scene);
    const ScratchFolder own;
    const auto reader = file_of(own, scene, dense);
    for (const std::int64_t flat : {0, 2, 5, 100}) {
      const auto source = make_flat_cubes(reader, reader->description(), flat, 2);
      ASSERT_EQ(planes_of(*source), evened_out(dense, flat).voxels)
          << scene.size.x << " flat " << flat;
    }
  }
}

TEST(FlatCubes, TheyAreThoseOfTheDefinition) {
  for (const Scene& scene : scenes()) {
    const ScratchFolder folder;
    const DenseVolume dense = dense_volume(scene);
    const auto reader = file_of(folder, scene, dense);
    const bool is_large = scene.size.voxel_count() > 1'000'000;
    for (const std::int64_t flat : is_large ? std::vector<std::int64_t>{1, 6}
                                            : std::vector<std::int64_t>{0, 1, 3, 6, 200}) {
      const int threads = flat == 6 ? 2 : 1;
      const auto source = make_flat_cubes(reader, reader->description(), flat, threads);
      ASSERT_EQ(planes_of(*source), evened_out(dense, flat).voxels)
          << scene.size.x << " flat " << flat;
    }
  }
}

TEST(FlatCubes, PlanesAreTheSameFromAnywhere) {
  const Scene& scene = scenes()[2];
  const ScratchFolder folder;
  const auto reader = file_of(folder, scene, dense_volume(scene));
  testing::expect_same_from_anywhere(*make_flat_cubes(reader, reader->description(), 6, 2));
}

TEST(FlatCubes, OfALossyFileTheyAreThoseOfItsVoxels) {
  const Scene& scene = scenes()[2];
  const ScratchFolder folder;
  const auto reader = file_of(folder, scene, dense_volume(scene), 2);
  ASSERT_GT(reader->max_error(), 0);
  DenseVolume decoded{scene.size, {}};
  decoded.voxels = values_of(testing::read_box(*reader, box_of(scene.size), 0), scene.type);
  const auto source = make_flat_cubes(reader, reader->description(), 3, 1);
  EXPECT_EQ(planes_of(*source), evened_out(decoded, 3).voxels);
}

TEST(FlatCubes, FloatsAreCondensedAsTheNumbersBehindThem) {
  const Scene scene{{67, 34, 70}, VoxelType::float32, {1, 1, 1}, 2, 30};
  const DenseVolume dense = dense_volume(scene);
  const auto voxel_of = [](std::int64_t number) {
    return static_cast<float>(static_cast<double>(number) * 0.1 - 7);
  };
  Volume volume;
  volume.description.type = scene.type;
  volume.description.size = scene.size;
  for (const std::int64_t number : dense.voxels) {
    const float voxel = voxel_of(number);
    const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
    volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof voxel);
  }
  const ScratchFolder folder;
  testing::build_volume(volume, folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  ASSERT_NEAR(reader->description().coding.value().scale, 0.1, 1e-12);
  for (const std::int64_t flat : {0, 3, 6, 200}) {
    const std::vector<std::int64_t> expected = evened_out(dense, flat).voxels;
    const auto source = make_flat_cubes(reader, reader->description(), flat, 2);
    std::vector<float> plane(static_cast<std::size_t>(scene.size.x * scene.size.y));
    std::size_t at = 0;
    for (std::int64_t z = 0; z < scene.size.z; ++z) {
      source->read_plane(std::as_writable_bytes(std::span(plane)));
      for (const float voxel : plane) ASSERT_EQ(voxel, voxel_of(expected[at++])) << flat;
    }
  }
}

TEST(FlatCubes, WhatHasNoMeanIsRejected) {
  const Scene& scene = scenes()[1];
  const ScratchFolder folder;
  const auto whole = file_of(folder, scene, dense_volume(scene));
  VolumeDescription labels = whole->description();
  labels.kind = VolumeKind::labels;
  EXPECT_THROW(make_flat_cubes(whole, labels, 1, 1), Error);
  EXPECT_THROW(make_flat_cubes(whole, whole->description(), -1, 1), Error);
  EXPECT_THROW(make_flat_cubes(whole, whole->description(), std::int64_t{1} << 60, 1), Error);
}

}  // namespace
}  // namespace octavo
