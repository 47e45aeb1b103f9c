#include "octavo/render/slice/section_samples.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <random>
#include <set>
#include <tuple>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using Brick = std::tuple<std::int64_t, std::int64_t, std::int64_t>;

/// A reader that notes the boxes it is asked for.
class NotingReader final : public FileReader {
 public:
  explicit NotingReader(std::shared_ptr<const FileReader> inner) : inner_(std::move(inner)) {}

  /// The bricks of a level that were read.
  std::set<Brick> bricks(int level) const {
    std::set<Brick> found;
    for (const Box& box : boxes_) {
      visit_cells(box, brick_side_at(levels(), level), [&](const Index3& b) {
        found.insert({b.x, b.y, b.z});
        return true;
      });
    }
    return found;
  }

  const VolumeDescription& description() const override { return inner_->description(); }
  const Levels& levels() const override { return inner_->levels(); }
  std::uint64_t file_bytes() const override { return inner_->file_bytes(); }
  std::uint64_t build_id() const override { return inner_->build_id(); }
  Sha256Digest voxel_digest() const override { return inner_->voxel_digest(); }
  const ByteSource& source() const override { return inner_->source(); }
  std::string format_version() const override { return inner_->format_version(); }
  ValueRange range() const override { return inner_->range(); }
  double max_error() const override { return inner_->max_error(); }
  double achieved_error() const override { return inner_->achieved_error(); }
  LevelSummary level_summary(int level) const override { return inner_->level_summary(level); }
  AxisOrder axis_order() const override { return inner_->axis_order(); }
  BrickEntry brick(int tier, const Index3& at) const override { return inner_->brick(tier, at); }
  void read_brick(const BrickEntry& entry, int level, void* out) const override {
    inner_->read_brick(entry, level, out);
  }
  void read(const Box& box, int level, void* out) const override {
    {
      const std::lock_guard lock(mutex_);
      boxes_.push_back(box);
    }
    inner_->read(box, level, out);
  }
  void read_strided(const Box& box, int level, void* out, std::int64_t row,
                    std::int64_t plane) const override {
    inner_->read_strided(box, level, out, row, plane);
  }
  int detail_level() const override { return inner_->detail_level(); }
  std::uint64_t thumbnail_bytes() const override { return inner_->thumbnail_bytes(); }
  Bytes thumbnail() const override { return inner_->thumbnail(); }
  Bytes read_piece(const BrickEntry& entry, int piece) const override {
    return inner_->read_piece(entry, piece);
  }

 private:
  std::shared_ptr<const FileReader> inner_;
  mutable std::mutex mutex_;
  mutable std::vector<Box> boxes_;
};

constexpr Size3 kSampledSize = {150, 140, 90};

class SectionSampling : public ::testing::Test {
 protected:
  void SetUp() override {
    volume_.description.type = VoxelType::int16;
    volume_.description.size = kSampledSize;
    Geometry& geometry = volume_.description.geometry;
    geometry.origin_mm = {-60, 12, 8};
    geometry.spacing_mm = {0.9, 0.7, 1.4};
    const double c = std::cos(0.3), s = std::sin(0.3);
    geometry.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
    std::mt19937 random(1);
    const auto count = static_cast<std::size_t>(kSampledSize.voxel_count());
    volume_.voxels.resize(2 * count);
    for (std::size_t i = 0; i < count; ++i) {
      const auto value = static_cast<std::int16_t>(random() % 5000);
      std::memcpy(volume_.voxels.data() + 2 * i, &value, 2);
    }
    testing::build_volume(volume_, folder_.file("v.8vo"), 1);
    reader_ = testing::open_file(folder_.file("v.8vo"));
  }

  PlaneSection section_of(const Point3& normal) const {
    const Point3 middle = reader_->description().geometry.to_world({70, 71, 44});
    return oblique_section(reader_->description().geometry, kSampledSize, {middle, normal}, 1);
  }

  testing::ScratchFolder folder_;
  testing::Volume volume_;
  std::shared_ptr<FileReader> reader_;
};

/// A dense level and its geometry, interpolated in the plainest way.
struct Dense {
  Size3 size;
  Geometry geometry;
  std::vector<std::byte> voxels;

  double at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    std::int16_t value;
    std::memcpy(&value, voxels.data() + 2 * ((z * size.y + y) * size.x + x), 2);
    return value;
  }

  /// Nothing outside.
  std::optional<double> linear(const Point3& world) const {
    const Point3 index = geometry.to_index(world);
    std::int64_t low[3];
    double share[3];
    for (int a = 0; a < 3; ++a) {
      double i = index[static_cast<std::size_t>(a)];
      const auto last = static_cast<double>(size[a] - 1);
      if (i < -0.5 || i > last + 0.5) return {};
      i = std::min(std::max(i, 0.0), last);
      low[a] = std::min(static_cast<std::int64_t>(i), std::max<std::int64_t>(0, size[a] - 2));
      share[a] = i - static_cast<double>(low[a]);
    }
    double sum = 0;
    for (int corner = 0; corner < 8; ++corner) {
      double weight = 1;
      std::int64_t at_corner[3];
      for (int a = 0; a < 3; ++a) {
        const int high = corner >> a & 1;
        weight *= high != 0 ? share[a] : 1 - share[a];
        at_corner[a] = std::min(low[a] + high, size[a] - 1);
      }
      sum += weight * at(at_corner[0], at_corner[1], at_corner[2]);
    }
    return sum;
  }
};

Dense dense(const FileReader& reader, int level) {
  const Size3 size = reader.levels().size(level);
  return {size, reader.levels().geometry(reader.description().geometry, level),
          testing::read_box(reader, box_of(size), level)};
}

TEST_F(SectionSampling, ObliqueSectionsAreThoseOfADenseVolume) {
  for (const int level : {0, 1, 3}) {
    const Dense volume = dense(*reader_, level);
    for (const Point3& normal :
         {Point3{1, 1, 1}, Point3{0.2, -1, 0.4}, Point3{0, 0.3, 1}, Point3{1, 0, 0}}) {
      const PlaneSection section = section_of(normal);
      const SectionSamples samples =
          sample_section(*reader_, level, section, SampleInterpolation::linear);
      std::int64_t inside = 0, off = 0;
      for (std::int64_t y = 0; y < section.height; ++y) {
        for (std::int64_t x = 0; x < section.width; ++x) {
          const auto expected =
              volume.linear(section.world.at(static_cast<double>(x), static_cast<double>(y)));
          if (!expected) {
            // A pixel exactly at the border may fall to either side.
            off += std::isnan(samples.at(x, y)) ? 0 : 1;
            continue;
          }
          ++inside;
          ASSERT_NEAR(samples.at(x, y), *expected, 1e-4);
        }
      }
      EXPECT_GT(inside, 5000);
      EXPECT_LT(off, 5);
    }
  }
}

TEST_F(SectionSampling, NearestSamplesAreSamples) {
  const Dense volume = dense(*reader_, 0);
  const PlaneSection section = section_of({1, -2, 3});
  const SectionSamples samples = sample_section(*reader_, 0, section, SampleInterpolation::nearest);
  for (std::int64_t y = 0; y < section.height; ++y) {
    for (std::int64_t x = 0; x < section.width; ++x) {
      if (std::isnan(samples.at(x, y))) continue;
      const Point3 index = volume.geometry.to_index(
          section.world.at(static_cast<double>(x), static_cast<double>(y)));
      std::int64_t nearest[3];
      for (int a = 0; a < 3; ++a) {
        nearest[a] = std::clamp<std::int64_t>(std::llround(index[static_cast<std::size_t>(a)]), 0,
                                              kSampledSize[a] - 1);
      }
      ASSERT_EQ(samples.at(x, y), volume.at(nearest[0], nearest[1], nearest[2]));
    }
  }
}

/// 20 x 20 x 20 voxels of 50 with a cube of 8 x 8 x 8 of another value.
std::shared_ptr<FileReader> cube_of(float value, const std::string& path) {
  testing::Volume volume;
  volume.description.type = VoxelType::float32;
  volume.description.size = {20, 20, 20};
  for (std::int64_t i = 0; i < 8000; ++i) {
    const auto is_within = [](std::int64_t at) { return at >= 6 && at < 14; };
    const bool is_cube = is_within(i % 20) && is_within(i / 20 % 20) && is_within(i / 400);
    const float voxel = is_cube ? value : 50;
    const auto* const bytes = reinterpret_cast<const std::byte*>(&voxel);
    volume.voxels.insert(volume.voxels.end(), bytes, bytes + sizeof voxel);
  }
  testing::build_volume(volume, path, 1);
  return testing::open_file(path);
}

TEST_F(SectionSampling, TheNearestVoxelCountsBesideInfinitiesAndNan) {
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float value : {infinity, -infinity, std::nanf("")}) {
    const auto reader = cube_of(value, folder_.file("cube.8vo"));
    const Geometry& geometry = reader->description().geometry;
    for (const Point3& normal : {Point3{0, 0, 1}, Point3{0.2, 0.3, 1}}) {
      const PlaneSection section =
          oblique_section(geometry, {20, 20, 20}, {{9.7, 10.2, 9.4}, normal}, 90);
      const SectionSamples linear =
          sample_section(*reader, 0, section, SampleInterpolation::linear);
      const SectionSamples nearest =
          sample_section(*reader, 0, section, SampleInterpolation::nearest);
      std::int64_t in_cube = 0;
      for (std::size_t i = 0; i < linear.values.size(); ++i) {
        const double voxel = nearest.values[i];
        in_cube += voxel == 50 ? 0 : 1;
        ASSERT_TRUE(linear.values[i] == voxel ||
                    (std::isnan(linear.values[i]) && std::isnan(voxel)));
      }
      EXPECT_GT(in_cube, 1000);
    }
    std::filesystem::remove(folder_.file("cube.8vo"));
  }
}

TEST_F(SectionSampling, HalfwayBetweenVoxelsTheHigherOneCounts) {
  // A plane just short of halfway, as far as a rounding: on other grids it counts as halfway.
  const auto reader = cube_of(9, folder_.file("cube.8vo"));
  const Geometry& geometry = reader->description().geometry;
  for (const double at : {5.5, 5.5 - 1e-9}) {
    const PlaneSection section =
        oblique_section(geometry, {20, 20, 20}, {{9.5, 9.5, at}, {0, 0, 1}}, 0);
    const SectionSamples samples =
        sample_section(*reader, 0, section, SampleInterpolation::nearest);
    const auto in_cube = std::count(samples.values.begin(), samples.values.end(), 9.0);
    EXPECT_GT(in_cube, 0) << at;
  }
}

TEST_F(SectionSampling, OnlyBricksThatThePlaneMeetsAreRead) {
  for (const Point3& normal : {Point3{1, 1, 1}, Point3{0.1, 0, 1}, Point3{1, -0.5, 0}}) {
    const NotingReader noting(reader_);
    const PlaneSection section = section_of(normal);
    sample_section(noting, 0, section, SampleInterpolation::linear);
    // The bricks of all samples that some pixel lies between.
    std::set<Brick> expected;
    const PixelMap map = index_map(section.world, reader_->description().geometry);
    for (std::int64_t y = 0; y < section.height; ++y) {
      for (std::int64_t x = 0; x < section.width; ++x) {
        const Point3 at = map.at(static_cast<double>(x), static_cast<double>(y));
        bool is_inside = true;
        Box cell;
        for (int a = 0; a < 3; ++a) {
          const double index = at[static_cast<std::size_t>(a)];
          const auto last = static_cast<double>(kSampledSize[a] - 1);
          is_inside = is_inside && index >= -0.5 && index <= last + 0.5;
          const double held = std::clamp(index, 0.0, last);
          cell.lo[a] = static_cast<std::int64_t>(std::floor(held));
          cell.hi[a] = static_cast<std::int64_t>(std::ceil(held)) + 1;
        }
        if (!is_inside) continue;
        visit_cells(cell, brick_side_at(reader_->levels(), 0), [&](const Index3& b) {
          expected.insert({b.x, b.y, b.z});
          return true;
        });
      }
    }
    EXPECT_EQ(noting.bricks(0), expected);
    EXPECT_LT(expected.size(), static_cast<std::size_t>(reader_->levels().brick_count(0)));
  }
}

TEST_F(SectionSampling, ThreadsDoNotChangeTheSamples) {
  const PlaneSection section = section_of({3, 2, 1});
  std::vector<SectionSamples> found;
  for (const int threads : {1, 2, 6}) {
    tbb::task_arena(threads).execute([&] {
      found.push_back(sample_section(*reader_, 0, section, SampleInterpolation::linear));
    });
  }
  for (std::size_t i = 0; i < found[0].values.size(); ++i) {
    for (const SectionSamples& other : found) {
      const double a = found[0].values[i], b = other.values[i];
      ASSERT_TRUE(a == b || (std::isnan(a) && std::isnan(b)));
    }
  }
}

TEST_F(SectionSampling, LevelsFollowThePixels) {
  EXPECT_EQ(level_for_pixels(*reader_, 0.1), 0);
  EXPECT_EQ(level_for_pixels(*reader_, 1.4), 0);
  EXPECT_EQ(level_for_pixels(*reader_, 2.8), 1);
  EXPECT_EQ(level_for_pixels(*reader_, 1e9), reader_->levels().count() - 1);
  EXPECT_THROW(sample_section(*reader_, 99, section_of({0, 0, 1}), SampleInterpolation::linear),
               Error);
}

}  // namespace
}  // namespace octavo
