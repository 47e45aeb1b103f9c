#include "octavo/ops/grid/resample.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <cmath>
#include <limits>
#include <random>

#include "octavo/core/error.h"
#include "support/built_file.h"
#include "support/dense_mask.h"
#include "support/voxel_numbers.h"

namespace octavo {
namespace {

/// A level of a file, dense, as numbers.
struct Dense {
  Size3 size;
  std::vector<double> voxels;

  /// The voxel there; those beyond the border are the ones at it.
  double at(std::int64_t x, std::int64_t y, std::int64_t z) const {
    x = std::clamp<std::int64_t>(x, 0, size.x - 1);
    y = std::clamp<std::int64_t>(y, 0, size.y - 1);
    z = std::clamp<std::int64_t>(z, 0, size.z - 1);
    return voxels[static_cast<std::size_t>((z * size.y + y) * size.x + x)];
  }
};

Dense dense_of(const FileReader& reader, int level) {
  const Size3 size = reader.levels().size(level);
  return {size, testing::as_numbers(testing::read_box(reader, box_of(size), level),
                           reader.description().type)};
}

/// A smooth wave with noise and a flat corner, in the range of the type.
template <class T>
testing::Volume wave(const Size3& size, double spacing_z_mm = 1) {
  testing::Volume volume;
  volume.description.size = size;
  volume.description.type = voxel_type_of<T>();
  volume.description.geometry.spacing_mm = {1, 1, spacing_z_mm};
  std::mt19937 random(7);
  std::vector<T> voxels;
  testing::for_each_voxel(size, [&](const Index3& p) {
    const double value = 60 + 40 * std::sin(static_cast<double>(p.x) / 5) *
                                  std::cos(static_cast<double>(p.y + p.z) / 7) +
                         static_cast<double>(random() % 9);
    voxels.push_back(p.x >= 64 && p.y >= 64 ? T{3} : static_cast<T>(value));
  });
  volume.voxels.resize(voxels.size() * sizeof(T));
  std::memcpy(volume.voxels.data(), voxels.data(), volume.voxels.size());
  return volume;
}

double cubic_of(double t, double a, double b, double c, double d) {
  // Catmull-Rom as it stands in textbooks.
  return 0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t +
                (3 * b - a - 3 * c + d) * t * t * t);
}

/// What the point p of the source holds, by the definition alone.
double expected_at(const Dense& source, const Point3& p, Interpolation interpolation,
                   double outside) {
  for (std::size_t a = 0; a < 3; ++a) {
    const auto size = static_cast<double>(source.size[static_cast<int>(a)]);
    if (p[a] < -0.5 - 1e-6 || p[a] >= size - 0.5 + 1e-6) return outside;
  }
  std::array<std::int64_t, 3> i{};
  Point3 t{};
  for (std::size_t a = 0; a < 3; ++a) {
    const double whole = std::floor(interpolation == Interpolation::nearest ? p[a] + 0.5 + 1e-6
                                                                            : p[a]);
    i[a] = static_cast<std::int64_t>(whole);
    t[a] = p[a] - whole;
  }
  const std::int64_t x = i[0];
  const std::int64_t y = i[1];
  const std::int64_t z = i[2];
  if (interpolation == Interpolation::nearest) return source.at(x, y, z);
  if (interpolation == Interpolation::linear) {
    double sum = 0;
    for (int n = 0; n < 8; ++n) {
      const int dx = n & 1;
      const int dy = n >> 1 & 1;
      const int dz = n >> 2;
      sum += (dx != 0 ? t[0] : 1 - t[0]) * (dy != 0 ? t[1] : 1 - t[1]) *
             (dz != 0 ? t[2] : 1 - t[2]) * source.at(x + dx, y + dy, z + dz);
    }
    return sum;
  }
  const auto along_x = [&](std::int64_t at_y, std::int64_t at_z) {
    return cubic_of(t[0], source.at(x - 1, at_y, at_z), source.at(x, at_y, at_z),
                    source.at(x + 1, at_y, at_z), source.at(x + 2, at_y, at_z));
  };
  const auto along_y = [&](std::int64_t at_z) {
    return cubic_of(t[1], along_x(y - 1, at_z), along_x(y, at_z), along_x(y + 1, at_z),
                    along_x(y + 2, at_z));
  };
  return cubic_of(t[2], along_y(z - 1), along_y(z), along_y(z + 1), along_y(z + 2));
}

/// A turn about a tilted axis with some stretching, so that the middle of the grid shows the middle
/// of the source.
Affine random_map(const Size3& grid, const Size3& source, std::mt19937& random) {
  std::uniform_real_distribution<double> part(-1.2, 1.2);
  Affine map;
  for (double& number : map.linear) number = part(random);
  for (std::size_t row = 0; row < 3; ++row) {
    double middle = static_cast<double>(source[static_cast<int>(row)]) / 2;
    for (int a = 0; a < 3; ++a) {
      middle -= map.linear[3 * row + static_cast<std::size_t>(a)] *
                static_cast<double>(grid[a]) / 2;
    }
    map.offset[row] = middle;
  }
  return map;
}

struct Opened {
  testing::ScratchFolder folder;
  std::shared_ptr<FileReader> reader;

  explicit Opened(const testing::Volume& volume, double max_error = 0) {
    NoProgress progress;
    BuildOptions options;
    options.kind = volume.description.kind;
    options.max_error = max_error;
    options.preset = Preset::fast;
    build_file(*make_memory_source(volume.description, volume.voxels), local_storage(),
               folder.file("v.8vo"), options, progress);
    reader = testing::open_file(folder.file("v.8vo"));
  }
};

std::vector<double> resampled(const FileReader& reader, int level, const Affine& map,
                              Interpolation interpolation, double outside, const Box& box) {
  const VoxelType type = reader.description().type;
  std::vector<std::byte> bytes(
      static_cast<std::size_t>(box.size().voxel_count() * bytes_per_voxel(type)));
  Resampler(reader, level, map, interpolation, outside).fill(box, bytes.data());
  return testing::as_numbers(bytes, type);
}

/// Holds every voxel of a grid against the definition. Interpolated integers may differ by one
/// where the sum lies next to a half.
void expect_resampled(const FileReader& reader, int level, const Affine& map, const Size3& grid,
                      Interpolation interpolation, double outside) {
  const Dense source = dense_of(reader, level);
  const bool is_float = !is_integer(reader.description().type);
  const std::vector<double> found =
      resampled(reader, level, map, interpolation, outside, box_of(grid));
  std::size_t i = 0;
  std::size_t different = 0;
  testing::for_each_voxel(grid, [&](const Index3& p) {
    const Point3 at = map({static_cast<double>(p.x), static_cast<double>(p.y),
                           static_cast<double>(p.z)});
    const double exact = expected_at(source, at, interpolation, outside);
    const double voxel = found[i++];
    if (interpolation == Interpolation::nearest) {
      different += voxel == exact ? 0u : 1u;
    } else if (is_float) {
      different += std::abs(voxel - exact) <= 1e-4 ? 0u : 1u;
    } else {
      const ValueRange range = value_range(reader.description().type);
      const double held = std::clamp(exact, static_cast<double>(range.min),
                                     static_cast<double>(range.max));
      different += std::abs(voxel - held) <= 0.5 + 1e-9 ? 0u : 1u;
    }
  });
  EXPECT_EQ(different, 0u) << "interpolation " << static_cast<int>(interpolation);
}

constexpr Interpolation kAll[] = {Interpolation::nearest, Interpolation::linear,
                                  Interpolation::cubic};

TEST(Resampler, GivesWhatTheDefinitionSaysForAnyMap) {
  std::mt19937 random(1);
  const Opened small(wave<std::int16_t>({90, 70, 67}));
  const Opened flat(wave<std::uint8_t>({75, 80, 33}, 4));
  for (int turn = 0; turn < 3; ++turn) {
    for (const Opened* opened : {&small, &flat}) {
      const Size3 grid{60, 51, 40};
      const Size3 size = opened->reader->levels().size(0);
      const Affine map = random_map(grid, size, random);
      for (const Interpolation way : kAll) {
        expect_resampled(*opened->reader, 0, map, grid, way, 5);
      }
    }
  }
}

// One whole voxel more may round a point to the voxel behind the next.
TEST(Resampler, CountsNeighborsFromTheVoxelBeforeAPoint) {
  const Opened opened(wave<std::int16_t>({20, 3, 2}));
  const double points[] = {-1e-17, -5e-17, std::nextafter(2.0, 0), std::nextafter(4.0, 0),
                           std::nextafter(8.0, 0), std::nextafter(16.0, 0)};
  for (const double first : points) {
    for (const Interpolation way : kAll) {
      Affine map;
      map.linear[0] = 0.5;
      map.offset[0] = first;
      expect_resampled(*opened.reader, 0, map, {40, 3, 2}, way, 5);
    }
  }
}

TEST(Resampler, GivesCoarserLevelsAndEveryType) {
  std::mt19937 random(2);
  const Size3 grid{30, 20, 37};
  const auto expect = [&](const Opened& opened, int level) {
    const Affine map = random_map(grid, opened.reader->levels().size(level), random);
    for (const Interpolation way : kAll) {
      expect_resampled(*opened.reader, level, map, grid, way, 2);
    }
  };
  const Opened grey(wave<std::int16_t>({90, 70, 67}));
  for (int level = 1; level < grey.reader->levels().count(); ++level) expect(grey, level);
  expect(Opened(wave<std::int8_t>({40, 30, 20})), 0);
  expect(Opened(wave<std::uint16_t>({40, 30, 20})), 0);
  expect(Opened(wave<std::int32_t>({40, 30, 20})), 0);
  expect(Opened(wave<std::uint32_t>({40, 30, 20})), 0);
  expect(Opened(wave<float>({40, 30, 20}), 0.01), 0);
}

TEST(Resampler, FollowsTheGridThatLiesAlongTheSource) {
  const Opened opened(wave<std::int16_t>({70, 36, 40}));
  const Size3 size{70, 36, 40};
  for (const AxisTurn& turn : {quarter_turns(0, 1), quarter_turns(1, 2), quarter_turns(2, 3),
                               mirror_along(1), AxisTurn{}}) {
    for (const Interpolation way : kAll) {
      expect_resampled(*opened.reader, 0, to_source(turn, size), turned(size, turn), way, 0);
    }
  }
  Affine shift;
  shift.offset = {-9, 36, 3};
  expect_resampled(*opened.reader, 0, shift, size, Interpolation::nearest, 5);
  shift.offset = {-9, 20, -30};
  expect_resampled(*opened.reader, 0, shift, size, Interpolation::nearest, 5);
  // Twice as fine, three times as coarse, and flat.
  Affine scaled;
  scaled.linear = {0.5, 0, 0, 0, 3, 0, 0, 0, 0};
  scaled.offset = {-0.25, 1, 30};
  for (const Interpolation way : kAll) {
    expect_resampled(*opened.reader, 0, scaled, {143, 14, 5}, way, 5);
  }
}

/// A wave of floats with a box of voxels that are no numbers.
testing::Volume wave_around(float value, const Box& box) {
  testing::Volume volume = wave<float>({30, 28, 26});
  testing::for_each_voxel(volume.description.size, [&](const Index3& p) {
    if (!box.contains(p)) return;
    const auto at = static_cast<std::size_t>((p.z * 28 + p.y) * 30 + p.x) * sizeof value;
    std::memcpy(volume.voxels.data() + at, &value, sizeof value);
  });
  return volume;
}

TEST(Resampler, TakesTheNearestVoxelBesideInfinitiesAndNan) {
  const float infinity = std::numeric_limits<float>::infinity();
  std::mt19937 random(5);
  const Size3 size{30, 28, 26};
  for (const float value : {infinity, -infinity, std::nanf("")}) {
    const Opened opened(wave_around(value, {{9, 9, 9}, {17, 18, 16}}));
    const Affine map = random_map(size, size, random);
    const std::vector<double> nearest =
        resampled(*opened.reader, 0, map, Interpolation::nearest, 7, box_of(size));
    const Dense source = dense_of(*opened.reader, 0);
    for (const Interpolation way : {Interpolation::linear, Interpolation::cubic}) {
      // What the map does not move stays as it is, to the last voxel.
      const std::vector<double> same =
          resampled(*opened.reader, 0, Affine{}, way, 7, box_of(size));
      const auto is_same = [](double a, double b) {
        return a == b || (std::isnan(a) && std::isnan(b));
      };
      EXPECT_TRUE(std::equal(same.begin(), same.end(), source.voxels.begin(), is_same));

      const std::vector<double> found =
          resampled(*opened.reader, 0, map, way, 7, box_of(size));
      std::size_t i = 0, off = 0, no_numbers = 0;
      testing::for_each_voxel(size, [&](const Index3& p) {
        const Point3 at = map({static_cast<double>(p.x), static_cast<double>(p.y),
                               static_cast<double>(p.z)});
        const double exact = expected_at(source, at, way, 7);
        const bool is_mixed = std::isfinite(exact);
        off += is_mixed ? std::abs(found[i] - exact) > 1e-4 : !is_same(found[i], nearest[i]);
        no_numbers += std::isfinite(found[i]) ? 0u : 1u;
        ++i;
      });
      EXPECT_EQ(off, 0u);
      EXPECT_GT(no_numbers, 100u);
    }
  }
}

TEST(Resampler, ReadsWhereOneVoxelOfTheGridStandsForMany) {
  // Neighbors of the grid lie in different bricks: tiles are cut down to what they need.
  const Opened opened(wave<std::uint8_t>({200, 190, 180}));
  Affine map;
  map.linear = {6, 0.5, 0, 0, 6, 0.25, 0.125, 0, 6};
  for (const Interpolation way : kAll) {
    expect_resampled(*opened.reader, 0, map, {33, 32, 31}, way, 5);
  }
}

TEST(Resampler, DoesNotDependOnBoxesAndThreads) {
  std::mt19937 random(3);
  const Opened opened(wave<std::int16_t>({90, 70, 67}));
  const Size3 grid{70, 50, 45};
  const Affine map = random_map(grid, {90, 70, 67}, random);
  for (const Interpolation way : kAll) {
    const std::vector<double> whole = resampled(*opened.reader, 0, map, way, 5, box_of(grid));
    const Box box{{13, 7, 5}, {64, 50, 44}};
    std::vector<double> part;
    tbb::task_arena(1).execute([&] { part = resampled(*opened.reader, 0, map, way, 5, box); });
    std::size_t i = 0;
    bool is_same = true;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z)
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y)
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          const auto at = static_cast<std::size_t>((z * grid.y + y) * grid.x + x);
          is_same = is_same && part[i++] == whole[at];
        }
    EXPECT_TRUE(is_same);
  }
}

TEST(Resampler, RejectsWhatIsNoMapOrLevel) {
  const Opened opened(wave<std::uint8_t>({9, 9, 9}));
  Affine map;
  EXPECT_THROW(Resampler(*opened.reader, -1, map, Interpolation::nearest, 0), Error);
  EXPECT_THROW(Resampler(*opened.reader, 99, map, Interpolation::nearest, 0), Error);
  map.offset[1] = std::nan("");
  EXPECT_THROW(Resampler(*opened.reader, 0, map, Interpolation::nearest, 0), Error);
  // Numbers so large that nothing is met.
  map.offset = {1e300, -1e300, 0};
  map.linear = {1e308, 1e308, 0, -1e308, 1e308, 0, 0, 0, 1};
  const std::vector<double> found =
      resampled(*opened.reader, 0, map, Interpolation::linear, 7, {{1, 1, 0}, {3, 3, 2}});
  EXPECT_EQ(found, std::vector<double>(8, 7));
}

TEST(ResampledMask, IsTheMaskOfTheResampledLabels) {
  std::mt19937 random(4);
  testing::Volume labels = wave<std::uint8_t>({70, 66, 40});
  labels.description.kind = VolumeKind::labels;
  const Opened opened(labels);
  const Size3 grid{90, 67, 70};
  const std::vector<ValueWindow> windows = {{50, 70}, {80, 300}};
  NoProgress progress;
  for (int turn = 0; turn < 2; ++turn) {
    const Affine map = random_map(grid, {70, 66, 40}, random);
    const std::vector<double> voxels =
        resampled(*opened.reader, 0, map, Interpolation::nearest, 0, box_of(grid));
    testing::DenseMask dense{grid, std::vector<std::uint8_t>(voxels.size())};
    for (std::size_t i = 0; i < voxels.size(); ++i) {
      dense.voxels[i] = windows[0].contains(voxels[i]) || windows[1].contains(voxels[i]) ? 1 : 0;
    }
    const MaskTree mask = resampled_mask(*opened.reader, map, grid, windows, progress);
    EXPECT_TRUE(is_valid(mask));
    EXPECT_EQ(mask, testing::tree_of(dense));
    EXPECT_THROW(resampled_mask(*opened.reader, map, grid, windows, progress, 1 << 10), Error);
  }
}

TEST(Affine, TheInverseLeadsBack) {
  std::mt19937 random(5);
  for (int turn = 0; turn < 20; ++turn) {
    const Affine map = random_map({50, 60, 70}, {100, 80, 90}, random);
    const std::optional<Affine> back = inverse(map);
    ASSERT_TRUE(back);
    const Point3 p = chained(map, *back)({3, -40, 11});
    EXPECT_NEAR(p[0], 3, 1e-9);
    EXPECT_NEAR(p[1], -40, 1e-9);
    EXPECT_NEAR(p[2], 11, 1e-9);
  }
  Affine flat;
  flat.linear = {1, 2, 3, 2, 4, 6, 0, 0, 1};
  EXPECT_FALSE(inverse(flat));
  flat.linear = {};
  EXPECT_FALSE(inverse(flat));
}

TEST(Affine, IsThatOfTheGeometryAndOfTheTurn) {
  Geometry geometry;
  geometry.origin_mm = {-40, 12.5, 7};
  geometry.spacing_mm = {0.5, 0.75, 3};
  geometry.direction = {0.8, -0.6, 0, 0.6, 0.8, 0, 0, 0, 1};
  const Point3 index{3, 5, 8};
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(index_to_world(geometry)(index)[i], geometry.to_world(index)[i], 1e-12);
  }
  const Size3 size{7, 5, 3};
  const AxisTurn turn = chained(quarter_turns(2, 1), mirror_along(0));
  const Index3 source = source_of({1, 2, 2}, size, turn);
  EXPECT_EQ(to_source(turn, size)({1, 2, 2}),
            (Point3{static_cast<double>(source.x), static_cast<double>(source.y),
                    static_cast<double>(source.z)}));
}

}  // namespace
}  // namespace octavo
