#include "octavo/mesh/memory_surface.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/mesh_check.h"
#include "support/built_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Noise with flat places in it.
template <class T>
std::vector<T> noisy_voxels(const Size3& size, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<T> voxels(static_cast<std::size_t>(size.voxel_count()));
  T value = 0;
  for (T& voxel : voxels) {
    if (random() % 3 == 0) value = static_cast<T>(random() % 100);
    voxel = value;
  }
  return voxels;
}

TriangleMesh of_memory(const VoxelsInMemory& volume, const SurfaceField& field, int threads = 1) {
  TriangleMesh mesh;
  NoProgress progress;
  tbb::task_arena(threads).execute([&] { mesh = surface_of(volume, field, progress); });
  return mesh;
}

template <class T>
TriangleMesh of_file(const VoxelsInMemory& volume, const std::vector<T>& voxels,
                     const SurfaceField& field) {
  testing::ScratchFolder folder;
  testing::Volume built;
  built.description.size = volume.size;
  built.description.type = volume.type;
  built.description.geometry = volume.geometry;
  const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
  built.voxels.assign(bytes, bytes + voxels.size() * sizeof(T));
  testing::build_volume(built, folder.file("v.8vo"), 1);
  MeshCollector collector;
  NoProgress progress;
  extract_surface(*testing::open_file(folder.file("v.8vo")), 0, field, collector, progress);
  return collector.take();
}

/// Triangles by the places of their corners, the smallest corner first, sorted.
std::vector<std::array<MeshPoint, 3>> sorted_triangles(const TriangleMesh& mesh) {
  std::vector<std::array<MeshPoint, 3>> all;
  for (const MeshTriangle& t : mesh.triangles) {
    auto& corners = all.emplace_back(
        std::array{mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]});
    std::rotate(corners.begin(), std::min_element(corners.begin(), corners.end()), corners.end());
  }
  std::sort(all.begin(), all.end());
  return all;
}

template <class T>
void expect_that_of_the_file(const Size3& size, const Geometry& geometry,
                             const SurfaceField& field) {
  const auto voxels = noisy_voxels<T>(size, static_cast<unsigned>(size.x));
  const VoxelsInMemory volume = {voxels.data(), voxel_type_of<T>(), size, geometry};
  const TriangleMesh mesh = of_memory(volume, field);
  const TriangleMesh file = of_file(volume, voxels, field);
  ASSERT_EQ(mesh.points.size(), file.points.size());
  ASSERT_EQ(mesh.triangles.size(), file.triangles.size());
  ASSERT_EQ(sorted_triangles(mesh), sorted_triangles(file));
  EXPECT_TRUE(check_mesh(mesh).is_closed());
  EXPECT_TRUE(check_mesh(mesh).is_manifold());
}

TEST(MemorySurface, IsThatOfTheFile) {
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  const Geometry mirrored = {{-7, 8, 9}, {0.5, 0.75, 2}, {c, -s, 0, s, c, 0, 0, 0, -1}};
  for (const Size3 size : {Size3{8, 8, 8}, Size3{64, 5, 3}, Size3{63, 65, 10}, Size3{130, 9, 70},
                           Size3{1, 1, 1}, Size3{1, 70, 2}}) {
    expect_that_of_the_file<std::int16_t>(size, mirrored,
                                          SurfaceField::of_grey(50, false, VoxelType::int16));
    expect_that_of_the_file<std::uint8_t>(size, {},
                                          SurfaceField::of_grey(70, true, VoxelType::uint8));
    expect_that_of_the_file<float>(size, {},
                                   SurfaceField::of_grey(33.3, false, VoxelType::float32));
  }
}

TEST(MemorySurface, DoesNotDependOnThreads) {
  const Size3 size = {90, 40, 51};
  const auto voxels = noisy_voxels<std::uint16_t>(size, 4);
  const VoxelsInMemory volume = {voxels.data(), VoxelType::uint16, size, {}};
  const SurfaceField field = SurfaceField::of_grey(60, false, VoxelType::uint16);
  const TriangleMesh mesh = of_memory(volume, field);
  EXPECT_FALSE(mesh.triangles.empty());
  EXPECT_EQ(of_memory(volume, field, 2), mesh);
  EXPECT_EQ(of_memory(volume, field, 7), mesh);
}

TEST(MemorySurface, OfNothingIsEmptyAndOfAllTheWholeBox) {
  const Size3 size = {5, 4, 3};
  const std::vector<std::uint8_t> voxels(60, 9);
  const VoxelsInMemory volume = {voxels.data(), VoxelType::uint8, size, {}};
  EXPECT_TRUE(
      of_memory(volume, SurfaceField::of_grey(10, false, VoxelType::uint8)).points.empty());
  const TriangleMesh box = of_memory(volume, SurfaceField::of_labels({}));
  EXPECT_EQ(check_mesh(box).components, 1u);
  EXPECT_EQ(check_mesh(box).euler_number, 2);
}

TEST(MemorySurface, StopsWhenAskedTo) {
  const Size3 size = {20, 20, 20};
  const auto voxels = noisy_voxels<std::uint8_t>(size, 1);
  testing::StoppingProgress progress;
  EXPECT_THROW(surface_of({voxels.data(), VoxelType::uint8, size, {}},
                          SurfaceField::of_grey(50, false, VoxelType::uint8), progress),
               Error);
}

}  // namespace
}  // namespace octavo
