#include "octavo/mesh/surface_piece.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <array>
#include <cmath>
#include <random>

#include "octavo/core/error.h"
#include "octavo/core/vectors.h"
#include "octavo/mesh/extraction.h"
#include "octavo/mesh/mesh_pieces.h"
#include "support/built_file.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// Tubes and balls of many sizes, some of which touch: pieces that pass borders of blocks.
class Tubes {
 public:
  Tubes() {
    testing::Volume volume;
    volume.description.size = size_;
    volume.description.type = VoxelType::int16;
    volume.description.geometry.spacing_mm = {0.5, 1, 1.5};
    std::mt19937 random(11);
    for (Point3& center : centers_) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        center[axis] = static_cast<double>(
            random() % static_cast<unsigned>(size_[static_cast<int>(axis)]));
      }
    }
    std::vector<std::int16_t> voxels;
    for (std::int64_t z = 0; z < size_.z; ++z) {
      for (std::int64_t y = 0; y < size_.y; ++y) {
        for (std::int64_t x = 0; x < size_.x; ++x) {
          voxels.push_back(value_at({double(x), double(y), double(z)}));
        }
      }
    }
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(std::int16_t));
    testing::build_volume(volume, folder_.file("v.8vo"), 1);
    reader_ = testing::open_file(folder_.file("v.8vo"));
  }

  const FileReader& reader() const { return *reader_; }
  const SurfaceField& field() const { return field_; }

  TriangleMesh whole(int level) const {
    MeshCollector collector;
    NoProgress progress;
    extract_surface(*reader_, level, field_, collector, progress);
    return collector.take();
  }

  std::optional<SurfacePiece> piece(int level, const Point3& seed, int threads = 1) const {
    std::optional<SurfacePiece> piece;
    NoProgress progress;
    tbb::task_arena(threads).execute(
        [&] { piece = surface_piece(*reader_, level, field_, seed, 0, progress); });
    return piece;
  }

 private:
  std::int16_t value_at(const Point3& place) const {
    double value = 0;
    for (std::size_t i = 0; i < centers_.size(); ++i) {
      Point3 apart = difference(place, centers_[i]);
      apart[i % 3] /= 1 + 10.0 * static_cast<double>(i % 2);
      const double radius = 4 + static_cast<double>(i % 4) * 2;
      value = std::max(value, 100 * (1 - std::sqrt(dot(apart, apart)) / (2 * radius)));
    }
    return static_cast<std::int16_t>(value);
  }

  Size3 size_ = {140, 135, 130};
  std::array<Point3, 14> centers_{};
  testing::ScratchFolder folder_;
  std::shared_ptr<FileReader> reader_;
  SurfaceField field_ = SurfaceField::of_grey(50, false, VoxelType::int16);
};

TEST(SurfacePiece, IsThatOfTheWholeSurface) {
  const Tubes tubes;
  for (const int level : {0, 1}) {
    const TriangleMesh whole = tubes.whole(level);
    const std::uint64_t count = mesh_pieces(whole).count;
    ASSERT_GT(count, 3u);
    const Geometry geometry =
        tubes.reader().levels().geometry(tubes.reader().description().geometry, level);
    std::size_t largest = 0;
    for (std::size_t i = 0; i < whole.points.size(); i += whole.points.size() / 12) {
      const MeshPoint& point = whole.points[i];
      const Point3 seed = geometry.to_index({point[0], point[1], point[2]});
      const auto piece = tubes.piece(level, seed);
      ASSERT_TRUE(piece);
      const NearestTriangle nearest = nearest_triangle(whole, geometry.to_world(seed));
      ASSERT_EQ(piece->mesh, piece_of_point(whole, whole.triangles[nearest.triangle][0]));
      EXPECT_EQ(tubes.piece(level, seed, 3)->mesh, piece->mesh);
      EXPECT_EQ(tubes.piece(level, seed, 3)->decoded_bricks, piece->decoded_bricks);
      largest = std::max(largest, piece->mesh.points.size());
    }
    EXPECT_LT(largest, whole.points.size());
  }
}

TEST(SurfacePiece, IsNothingAwayFromTheSurface) {
  testing::ScratchFolder folder;
  testing::Volume volume;
  volume.description.size = {40, 40, 40};
  volume.description.type = VoxelType::uint8;
  volume.voxels.assign(64'000, std::byte{0});
  volume.voxels[20] = std::byte{9};
  testing::build_volume(volume, folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  const SurfaceField field = SurfaceField::of_grey(5, false, VoxelType::uint8);
  NoProgress progress;
  EXPECT_FALSE(surface_piece(*reader, 0, field, {20, 20, 20}, 0, progress));
  EXPECT_FALSE(surface_piece(*reader, 0, field, {20, 3, 0}, 0, progress));
  EXPECT_TRUE(surface_piece(*reader, 0, field, {20, 1, 0}, 0, progress));
}

TEST(SurfacePiece, DecodesOnlyBricksThatItPasses) {
  // Noise above and below the surface of two plates, one at either end.
  const Size3 size = {64 * 8, 64, 64};
  std::mt19937 random(3);
  testing::Volume volume;
  volume.description.size = size;
  volume.description.type = VoxelType::uint8;
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    const std::int64_t x = i % size.x;
    const bool is_inside = (x >= 20 && x < 40) || (x >= 470 && x < 490);
    volume.voxels.push_back(std::byte(random() % 40 + (is_inside ? 100u : 0u)));
  }
  testing::ScratchFolder folder;
  testing::build_volume(volume, folder.file("v.8vo"), 1);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  const SurfaceField field = SurfaceField::of_grey(70, false, VoxelType::uint8);
  NoProgress progress;
  const auto piece = surface_piece(*reader, 0, field, {20, 30, 30}, 0, progress);
  ASSERT_TRUE(piece);
  EXPECT_EQ(mesh_pieces(piece->mesh).count, 1u);
  EXPECT_EQ(piece->decoded_bricks, 1u);
}

TEST(SurfacePiece, KeepsToTheLimitAndStopsWhenAskedTo) {
  const Tubes tubes;
  const MeshPoint point = tubes.whole(0).points.front();
  const Point3 seed = {point[0] / 0.5, point[1] / 1.0, point[2] / 1.5};
  NoProgress progress;
  EXPECT_THROW(surface_piece(tubes.reader(), 0, tubes.field(), seed, 1000, progress), Error);
  testing::StoppingProgress stopping;
  EXPECT_THROW(surface_piece(tubes.reader(), 0, tubes.field(), seed, 0, stopping), Error);
}

}  // namespace
}  // namespace octavo
