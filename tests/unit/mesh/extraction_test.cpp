#include "octavo/mesh/extraction.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <numeric>
#include <random>

#include "octavo/core/error.h"
#include "octavo/mesh/mesh_check.h"
#include "support/built_file.h"
#include "support/counting_source.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

/// A volume of one type, and the file made of it.
class BuiltVolume {
 public:
  template <class T>
  BuiltVolume(const Size3& size, const std::vector<T>& voxels, const Geometry& geometry = {},
              VolumeKind kind = VolumeKind::grey) {
    testing::Volume volume;
    volume.description.kind = kind;
    volume.description.size = size;
    volume.description.type = voxel_type_of<T>();
    volume.description.geometry = geometry;
    volume.description.metadata = Metadata::read(R"({"spacing_known":true})");
    const auto* bytes = reinterpret_cast<const std::byte*>(voxels.data());
    volume.voxels.assign(bytes, bytes + voxels.size() * sizeof(T));
    testing::build_volume(volume, path_, 1);
    reader_ = testing::open_file(path_);
  }

  const FileReader& reader() const { return *reader_; }
  const std::string& path() const { return path_; }

  TriangleMesh surface(const SurfaceField& field, int level = 0, int threads = 1) const {
    MeshCollector collector;
    NoProgress progress;
    tbb::task_arena(threads).execute(
        [&] { extract_surface(*reader_, level, field, collector, progress); });
    return collector.take();
  }

 private:
  testing::ScratchFolder folder_;
  std::string path_ = folder_.file("v.8vo");
  std::shared_ptr<FileReader> reader_;
};

SurfaceField above(double value) {
  return SurfaceField::of_grey(value, false, VoxelType::int16);
}

std::size_t voxel_place(const Size3& size, std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::size_t>((z * size.y + y) * size.x + x);
}

/// Noise, or blobs where it is smoothed along x.
std::vector<std::int16_t> random_voxels(const Size3& size, unsigned seed, int smoothing) {
  std::mt19937 random(seed);
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::int16_t& voxel : voxels) voxel = static_cast<std::int16_t>(random() % 1000);
  for (int i = 0; i < smoothing; ++i) {
    const std::vector<std::int16_t> sharp = voxels;
    for (std::size_t at = 0; at < voxels.size(); ++at) {
      const std::size_t row = static_cast<std::size_t>(size.x);
      const std::size_t plane = row * static_cast<std::size_t>(size.y);
      int sum = 0;
      for (const std::size_t step : {std::size_t{0}, std::size_t{1}, row, plane}) {
        sum += sharp[(at + step) % sharp.size()];
      }
      voxels[at] = static_cast<std::int16_t>(sum / 4);
    }
  }
  return voxels;
}

/// Components of a padded mask, and the Euler number of its inside as a body. Voxels inside hang
/// together by faces, those outside by faces and edges.
struct MaskTopology {
  std::uint64_t inside_components = 0;
  std::uint64_t outside_components = 0;
  std::int64_t euler_number = 0;
};

class PaddedMask {
 public:
  PaddedMask(const Size3& size, const std::vector<std::int16_t>& voxels, int threshold)
      : size_{size.x + 2, size.y + 2, size.z + 2},
        bits_(static_cast<std::size_t>(size_.voxel_count())) {
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x) {
          bits_[voxel_place(size_, x + 1, y + 1, z + 1)] =
              voxels[voxel_place(size, x, y, z)] >= threshold ? 1 : 0;
        }
      }
    }
  }

  MaskTopology topology() const {
    return {components(1, 1), components(0, 2), euler_number()};
  }

 private:
  /// Of voxels of a value, joined to those that differ in at most `most` coordinates.
  std::uint64_t components(int value, int most) const {
    std::vector<bool> is_seen(bits_.size());
    std::uint64_t count = 0;
    for (std::size_t start = 0; start < bits_.size(); ++start) {
      if (is_seen[start] || bits_[start] != value) continue;
      ++count;
      std::vector<std::size_t> waiting = {start};
      is_seen[start] = true;
      while (!waiting.empty()) {
        const auto at = static_cast<std::int64_t>(waiting.back());
        waiting.pop_back();
        const Index3 p = {at % size_.x, at / size_.x % size_.y, at / size_.x / size_.y};
        visit_around(p, most, [&](const Index3& q) {
          const std::size_t other = voxel_place(size_, q.x, q.y, q.z);
          if (is_seen[other] || bits_[other] != value) return;
          is_seen[other] = true;
          waiting.push_back(other);
        });
      }
    }
    return count;
  }

  template <class Visit>
  void visit_around(const Index3& p, int most, Visit visit) const {
    for (std::int64_t i = 0; i < 27; ++i) {
      const Index3 d = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const std::int64_t moved = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
      const Index3 q = {p.x + d.x, p.y + d.y, p.z + d.z};
      if (moved > 0 && moved <= most && box_of(size_).contains(q)) visit(q);
    }
  }

  /// Voxels - pairs + squares of four - cubes of eight, and a body fills the ring of six voxels
  /// around the middle of a cube.
  std::int64_t euler_number() const {
    std::int64_t sum = 0;
    for (std::int64_t z = 0; z + 1 < size_.z; ++z) {
      for (std::int64_t y = 0; y + 1 < size_.y; ++y) {
        for (std::int64_t x = 0; x + 1 < size_.x; ++x) {
          sum += is_ring({x, y, z}) ? 1 : 0;
          for (std::int64_t extent = 0; extent < 8; ++extent) {
            bool is_full = true;
            for (std::int64_t corner = 0; corner < 8; ++corner) {
              if ((corner & ~extent) != 0) continue;
              const std::size_t at =
                  voxel_place(size_, x + (corner & 1), y + (corner >> 1 & 1), z + (corner >> 2));
              is_full = is_full && bits_[at] == 1;
            }
            if (is_full) sum += __builtin_popcountll(static_cast<unsigned>(extent)) % 2 ? -1 : 1;
          }
        }
      }
    }
    return sum;
  }

  /// Whether of the cube of eight at a voxel two opposite ones alone lie outside.
  bool is_ring(const Index3& p) const {
    unsigned outside = 0;
    for (unsigned corner = 0; corner < 8; ++corner) {
      const std::size_t at =
          voxel_place(size_, p.x + (corner & 1), p.y + (corner >> 1 & 1), p.z + (corner >> 2));
      if (bits_[at] == 0) outside |= 1u << corner;
    }
    return outside == 0x81 || outside == 0x42 || outside == 0x24 || outside == 0x18;
  }

  Size3 size_;
  std::vector<int> bits_;
};

TEST(Extraction, IsClosedManifoldAndHasTheTopologyOfTheMask) {
  for (const auto& [size, threshold, smoothing] :
       {std::tuple{Size3{8, 8, 8}, 500, 0}, std::tuple{Size3{8, 8, 8}, 300, 0},
        std::tuple{Size3{9, 7, 5}, 700, 0}, std::tuple{Size3{66, 9, 65}, 500, 2},
        std::tuple{Size3{63, 64, 10}, 480, 3}, std::tuple{Size3{1, 70, 2}, 500, 0}}) {
    const auto voxels = random_voxels(size, static_cast<unsigned>(size.x + threshold), smoothing);
    const BuiltVolume volume(size, voxels);
    const TriangleMesh mesh = volume.surface(above(threshold));
    const MeshCheck check = check_mesh(mesh);
    const MaskTopology mask = PaddedMask(size, voxels, threshold).topology();
    EXPECT_TRUE(check.is_closed());
    EXPECT_TRUE(check.is_manifold());
    EXPECT_EQ(check.euler_number, 2 * mask.euler_number);
    EXPECT_EQ(check.components, mask.inside_components + mask.outside_components - 1);
    EXPECT_GT(measure_mesh(mesh).volume_mm3, 0);
  }
}

TEST(Extraction, DoesNotDependOnThreadsOrBricks) {
  const Size3 size = {130, 70, 66};
  const auto voxels = random_voxels(size, 1, 3);
  Geometry flat;
  flat.spacing_mm[2] = 4;  // makes bricks flat
  const BuiltVolume even(size, voxels);
  const BuiltVolume uneven(size, voxels, flat);
  ASSERT_NE(even.reader().levels().brick_side(0), uneven.reader().levels().brick_side(0));
  const TriangleMesh mesh = even.surface(above(500));
  EXPECT_EQ(even.surface(above(500), 0, 2), mesh);
  EXPECT_EQ(even.surface(above(500), 0, 7), mesh);
  TriangleMesh stretched = mesh;
  for (MeshPoint& point : stretched.points) point[2] *= 4;
  EXPECT_EQ(uneven.surface(above(500)), stretched);
}

TEST(Extraction, EnclosesTheSameBodyOnEveryGrid) {
  const Size3 size = {20, 18, 16};
  const auto voxels = random_voxels(size, 5, 3);
  const double index_volume =
      measure_mesh(BuiltVolume(size, voxels).surface(above(500))).volume_mm3;
  const double c = std::cos(0.5);
  const double s = std::sin(0.5);
  Geometry turned{{100, -200, 50}, {0.5, 0.75, 2}, {c, -s, 0, s, c, 0, 0, 0, 1}};
  Geometry mirrored{{-7, 8, 9}, {0.5, 0.75, 2}, {1, 0, 0, 0, 1, 0, 0, 0, -1}};
  for (const Geometry& geometry : {turned, mirrored}) {
    const TriangleMesh mesh = BuiltVolume(size, voxels, geometry).surface(above(500));
    EXPECT_NEAR(measure_mesh(mesh).volume_mm3, index_volume * 0.75, index_volume * 1e-4);
    EXPECT_TRUE(check_mesh(mesh).is_closed());
  }
}

TEST(Extraction, CutsWhereTheIsovalueLies) {
  const Size3 size = {70, 66, 4};
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    voxels[i] = static_cast<std::int16_t>(10 * (i % static_cast<std::size_t>(size.x)));
  }
  // 644.5 lies at x = 64.45, between two blocks.
  const TriangleMesh mesh = BuiltVolume(size, voxels).surface(above(645));
  std::size_t on_plane = 0;
  for (const MeshPoint& point : mesh.points) {
    if (std::abs(point[0] - 64.45f) < 1e-4f) ++on_plane;
    else EXPECT_GT(point[0], 64.4f);
  }
  EXPECT_EQ(on_plane, static_cast<std::size_t>(size.y * size.z));
}

TEST(Extraction, OfLabelsCutsInTheMiddleAndTakesThoseAskedFor) {
  const Size3 size = {6, 5, 4};
  std::vector<std::uint8_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  voxels[voxel_place(size, 2, 2, 2)] = 3;
  voxels[voxel_place(size, 0, 0, 0)] = 5;
  const BuiltVolume volume(size, voxels, {}, VolumeKind::labels);
  const TriangleMesh one = volume.surface(SurfaceField::of_labels(std::vector<std::int64_t>{3}));
  EXPECT_EQ(one.triangles.size(), 8u);
  EXPECT_NEAR(measure_mesh(one).volume_mm3, 1.0 / 6, 1e-6);
  // At the border of the volume as well.
  const TriangleMesh all = volume.surface(SurfaceField::of_labels({}));
  EXPECT_EQ(check_mesh(all).components, 2u);
  EXPECT_NEAR(measure_mesh(all).volume_mm3, 2.0 / 6, 1e-6);
}

TEST(Extraction, OfACoarseLevelLiesWhereItsSamplesDo) {
  const Size3 size = {64, 64, 64};
  std::vector<std::int16_t> voxels(static_cast<std::size_t>(size.voxel_count()));
  for (std::int64_t z = 16; z < 48; ++z) {
    for (std::int64_t y = 16; y < 48; ++y) {
      for (std::int64_t x = 16; x < 48; ++x) voxels[voxel_place(size, x, y, z)] = 100;
    }
  }
  const BuiltVolume volume(size, voxels);
  for (int level = 0; level < 3; ++level) {
    const TriangleMesh mesh = volume.surface(above(50), level);
    EXPECT_TRUE(check_mesh(mesh).is_closed());
    Point3 sum{};
    for (const MeshPoint& p : mesh.points) {
      for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += static_cast<double>(p[axis]);
    }
    for (const double value : sum) {
      EXPECT_NEAR(value / static_cast<double>(mesh.points.size()), 31.5, 1e-3);
    }
  }
}

TEST(Extraction, DoesNotReadBricksThatTheirRangeDecides) {
  const Size3 size = {64 * 6, 64, 64};
  std::vector<std::int16_t> voxels = random_voxels(size, 9, 0);
  // Below, then above from x = 80 on; noise everywhere.
  for (std::size_t i = 0; i < voxels.size(); ++i) {
    const bool is_inside = i % static_cast<std::size_t>(size.x) >= 80;
    voxels[i] = static_cast<std::int16_t>(voxels[i] % 50 + (is_inside ? 100 : 0));
  }
  // Another one beside the border, so that the surface closes away from most bricks.
  for (std::int64_t z = 0; z < size.z; ++z) {
    for (std::int64_t y = 0; y < size.y; ++y) {
      for (std::int64_t x = 100; x < size.x; ++x) {
        voxels[voxel_place(size, x, y, z)] =
            static_cast<std::int16_t>(voxels[voxel_place(size, x, y, z)] % 50);
      }
    }
  }
  const BuiltVolume volume(size, voxels);
  const std::string bytes = testing::bytes_of_file(volume.path());
  const auto source = std::make_shared<testing::CountingSource>(
      std::vector<std::uint8_t>(bytes.begin(), bytes.end()));
  const auto reader = FileReader::open(source);
  const std::uint64_t opening = source->bytes;
  MeshCollector collector;
  NoProgress progress;
  extract_surface(*reader, 0, above(75), collector, progress);
  EXPECT_EQ(collector.take(), volume.surface(above(75)));
  EXPECT_GT(source->bytes - opening, bytes.size() / 10);
  EXPECT_LT(source->bytes - opening, bytes.size() / 4);
}

TEST(Extraction, StopsWhenAskedTo) {
  const Size3 size = {20, 20, 20};
  const BuiltVolume volume(size, random_voxels(size, 2, 0));
  testing::StoppingProgress progress;
  MeshCollector collector;
  EXPECT_THROW(extract_surface(volume.reader(), 0, above(500), collector, progress), Error);
}

TEST(Extraction, KeepsNoMoreThanTheLimit) {
  const Size3 size = {40, 40, 40};
  const BuiltVolume volume(size, random_voxels(size, 2, 0));
  MeshCollector collector(10'000);
  NoProgress progress;
  try {
    extract_surface(volume.reader(), 0, above(500), collector, progress);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
  }
}

}  // namespace
}  // namespace octavo
