#include "octavo/render/transparency/line_integrals.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>
#include <memory>
#include <random>
#include <set>

#include "octavo/core/error.h"
#include "octavo/octree/condense.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using testing::ScratchFolder;
using testing::Volume;

/// What a volume looks like: boxes of a few values in a surrounding, noise in some of them.
struct Scene {
  Size3 size;
  VoxelType type = VoxelType::uint8;
  Point3 spacing{1, 1, 1};
  int noise = 0;
};

class ValueCube {
 public:
  explicit ValueCube(const Scene& scene, unsigned seed = 7) : size_(scene.size) {
    std::mt19937 random(seed);
    values_.assign(static_cast<std::size_t>(size_.voxel_count()), 10);
    for (int i = 0; i < 6; ++i) {
      Box box;
      for (int a = 0; a < 3; ++a) {
        const auto p = static_cast<std::int64_t>(random() % static_cast<unsigned>(size_[a]));
        const auto q = static_cast<std::int64_t>(random() % static_cast<unsigned>(size_[a]));
        box.lo[a] = std::min(p, q);
        box.hi[a] = std::max(p, q) + 1;
      }
      const int value = static_cast<int>(20 + random() % 80);
      const int noise = i % 2 == 0 ? scene.noise : 0;
      fill(box, [&] { return value + (noise > 0 ? static_cast<int>(random()) % noise : 0); });
    }
  }

  const Size3& size() const { return size_; }
  int at(const Index3& v) const {
    return values_[static_cast<std::size_t>((v.z * size_.y + v.y) * size_.x + v.x)];
  }
  const std::vector<int>& values() const { return values_; }

 private:
  template <class Value>
  void fill(const Box& box, Value value) {
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
          values_[static_cast<std::size_t>((z * size_.y + y) * size_.x + x)] = value();
        }
      }
    }
  }

  Size3 size_;
  std::vector<int> values_;
};

std::shared_ptr<FileReader> file_of(const ScratchFolder& folder, const Scene& scene,
                                    const ValueCube& cube) {
  Volume volume;
  volume.description.type = scene.type;
  volume.description.size = scene.size;
  volume.description.geometry.spacing_mm = scene.spacing;
  const auto width = static_cast<std::size_t>(bytes_per_voxel(scene.type));
  volume.voxels.resize(cube.values().size() * width);
  with_voxel_type(scene.type, [&](auto id) {
    using T = typename decltype(id)::type;
    for (std::size_t i = 0; i < cube.values().size(); ++i) {
      const auto value = static_cast<T>(cube.values()[i]);
      std::memcpy(volume.voxels.data() + i * width, &value, width);
    }
  });
  testing::build_volume(volume, folder.file("v.8vo"), 2);
  return testing::open_file(folder.file("v.8vo"));
}

/// The voxels of every line, the farthest first, by the lattice point (u, v).
std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Index3>> visited_lines(
    const VoxelLines& lines) {
  std::map<std::pair<std::int64_t, std::int64_t>, std::vector<Index3>> visited;
  const Size3& s = lines.size;
  const Direction d = lines.along;
  for (std::int64_t i = 0; i < s.voxel_count(); ++i) {
    Index3 v{i % s.x, i / s.x % s.y, i / (s.x * s.y)};
    const auto next = [&](int sign) {
      return Index3{v.x + sign * d.x, v.y + sign * d.y, v.z + sign * d.z};
    };
    if (box_of(s).contains(next(1))) continue;  // not the farthest of its line
    auto& line = visited[{lines.u_of(v), lines.v_of(v)}];
    for (; box_of(s).contains(v); v = next(-1)) line.push_back(v);
  }
  return visited;
}

/// Calls visit(voxel, line) for all voxels, those of a line from the farthest to the nearest.
template <class Visit>
void visit_farthest_first(const VoxelLines& lines, Visit visit) {
  const Size3& s = lines.size;
  const Direction d = lines.along;
  for (std::int64_t k = 0; k < s.z; ++k) {
    for (std::int64_t j = 0; j < s.y; ++j) {
      for (std::int64_t i = 0; i < s.x; ++i) {
        const Index3 v{d.x > 0 ? s.x - 1 - i : i, d.y > 0 ? s.y - 1 - j : j,
                       d.z > 0 ? s.z - 1 - k : k};
        visit(v, static_cast<std::size_t>(lines.v_of(v) * lines.width + lines.u_of(v)));
      }
    }
  }
}

const std::vector<Scene>& scenes() {
  static const std::vector<Scene> all = {
      {{1, 1, 1}, VoxelType::uint8, {1, 1, 1}, 0},
      {{5, 7, 3}, VoxelType::int16, {1, 1, 1}, 9},
      {{67, 70, 65}, VoxelType::uint8, {1, 1, 1}, 20},
      {{130, 20, 66}, VoxelType::float32, {1, 1, 1}, 0},
      {{80, 66, 40}, VoxelType::uint16, {0.5, 0.5, 2}, 5},
      {{140, 130, 129}, VoxelType::uint8, {1, 1, 1}, 0},
  };
  return all;
}

/// A scene in a file, made once for all tests.
struct SceneFile {
  ScratchFolder folder;
  Scene scene;
  ValueCube cube;
  std::shared_ptr<FileReader> reader;

  explicit SceneFile(const Scene& what) : scene(what), cube(what) {
    reader = file_of(folder, scene, cube);
  }
};

const std::vector<std::unique_ptr<SceneFile>>& scene_files() {
  static const auto files = [] {
    std::vector<std::unique_ptr<SceneFile>> made;
    for (const Scene& scene : scenes()) made.push_back(std::make_unique<SceneFile>(scene));
    return made;
  }();
  return files;
}

/// All 26, or one of each kind where a visit to every voxel takes long.
std::vector<Direction> directions_for(const Scene& scene) {
  if (scene.size.voxel_count() > 1'000'000) return {{0, -1, 0}, {-1, 0, 1}, {1, -1, -1}};
  return {kDirections.begin(), kDirections.end()};
}

/// Emission of an odd pattern; that of class 0 is nothing.
std::vector<std::int32_t> emission_of(const DensityClasses& classes, int channels) {
  std::vector<std::int32_t> light;
  for (std::size_t i = 0; i < classes.count() * static_cast<std::size_t>(channels); ++i) {
    light.push_back(static_cast<std::int32_t>((i * 7919) % 1013));
  }
  std::fill_n(light.begin(), channels, 0);
  return light;
}

std::vector<ClassTransfer> transfer_of(const DensityClasses& classes) {
  std::vector<ClassTransfer> transfer(classes.count());
  for (std::size_t i = 1; i < transfer.size(); ++i) {
    transfer[i].opacity = static_cast<float>(i % 5) / 20;
    for (std::size_t c = 0; c < 3; ++c) {
      transfer[i].color[c] = static_cast<float>((i * (c + 3)) % 11) / 11;
    }
  }
  return transfer;
}

DensityClasses identity(const FileReader& reader) {
  return DensityClasses::ramp(reader.description(), 0, 255, 255);
}

TEST(VoxelLines, EveryVoxelLiesOnItsLineAndEveryLineIsInTheLattice) {
  const Size3 size{5, 4, 7};
  for (const Direction& along : kDirections) {
    const VoxelLines lines = voxel_lines(size, along);
    std::set<std::pair<std::int64_t, std::int64_t>> farthest;
    std::int64_t voxels = 0;
    for (const auto& [place, line] : visited_lines(lines)) {
      for (const Index3& v : line) {
        ++voxels;
        EXPECT_EQ(std::pair(lines.u_of(v), lines.v_of(v)), place);
      }
      EXPECT_TRUE(farthest.insert(place).second);
      EXPECT_TRUE(place.first >= 0 && place.first < lines.width);
      EXPECT_TRUE(place.second >= 0 && place.second < lines.height);
    }
    EXPECT_EQ(voxels, size.voxel_count());
  }
}

TEST(VoxelLines, ACubeGivesEveryLineItsVoxels) {
  for (const Direction& along : kDirections) {
    for (const std::int64_t side : {1, 2, 3, 8}) {
      const VoxelLines lines = voxel_lines({side, side, side}, along);
      std::map<std::pair<std::int64_t, std::int64_t>, std::int64_t> counted;
      for_each_line(lines.axes, side, [&](std::int64_t u, std::int64_t v, std::int64_t count) {
        counted[{u, v}] = count;
      });
      const auto visited = visited_lines(lines);
      ASSERT_EQ(counted.size(), visited.size());
      for (const auto& [place, line] : visited) {
        EXPECT_EQ(counted.at(place), static_cast<std::int64_t>(line.size()));
      }
    }
  }
}

TEST(VoxelLines, DirectionsOffTheLatticeAreRejected) {
  for (const Direction& along : {Direction{0, 0, 0}, Direction{2, 0, 0}, Direction{1, -2, 1}}) {
    EXPECT_THROW(voxel_lines({4, 4, 4}, along), Error);
  }
}

TEST(VoxelLines, NoLineLeavesAnOctantForOneDrawnBeforeIt) {
  for (const Direction& along : kDirections) {
    const auto order = back_to_front(along);
    EXPECT_EQ(std::set<int>(order.begin(), order.end()).size(), 8U);
    const auto rank = [&](const Index3& v) {
      const int octant = static_cast<int>(4 * (v.z / 4) + 2 * (v.x / 4) + v.y / 4);
      return std::find(order.begin(), order.end(), octant) - order.begin();
    };
    for (const auto& [place, line] : visited_lines(voxel_lines({8, 8, 8}, along))) {
      for (std::size_t i = 1; i < line.size(); ++i) EXPECT_LE(rank(line[i - 1]), rank(line[i]));
    }
  }
}

TEST(LineIntegrals, TheStraightSumIsThatOfEveryVoxelInAll26Directions) {
  for (const auto& file : scene_files()) {
    const auto& [folder, scene, cube, reader] = *file;
    const DensityClasses classes = identity(*reader);
    const auto light = emission_of(classes, 3);
    for (const Direction& along : directions_for(scene)) {
      NoProgress progress;
      const LineSums found = sum_along_lines(*reader, {0, along, {}}, classes, light, 3, progress);
      std::vector<std::int64_t> expected(found.sums.size(), 0);
      visit_farthest_first(found.lines, [&, &values = cube](const Index3& v, std::size_t line) {
        for (std::size_t c = 0; c < 3; ++c) {
          expected[line * 3 + c] += light[static_cast<std::size_t>(values.at(v)) * 3 + c];
        }
      });
      ASSERT_EQ(found.sums, expected) << along.x << along.y << along.z;
    }
  }
}

TEST(LineIntegrals, TheAverageIsThatOfEveryVoxelInAll26Directions) {
  for (const auto& file : scene_files()) {
    const auto& [folder, scene, cube, reader] = *file;
    const DensityClasses classes = identity(*reader);
    const auto transfer = transfer_of(classes);
    for (const Direction& along : directions_for(scene)) {
      NoProgress progress;
      const LineAverages found =
          average_along_lines(*reader, {0, along, {}}, classes, transfer, progress);
      std::vector<std::array<double, 4>> expected(found.colors.size(), {0, 0, 0, 1});
      visit_farthest_first(found.lines, [&, &values = cube](const Index3& v, std::size_t line) {
        const ClassTransfer& one = transfer[static_cast<std::size_t>(values.at(v))];
        const double a = static_cast<double>(one.opacity);
        for (std::size_t c = 0; c < 3; ++c) {
          expected[line][c] = expected[line][c] * (1 - a) + static_cast<double>(one.color[c]) * a;
        }
        expected[line][3] *= 1 - a;
      });
      double worst = 0;
      for (std::size_t i = 0; i < expected.size(); ++i) {
        for (std::size_t c = 0; c < 4; ++c) {
          const double difference = static_cast<double>(found.colors[i][c]) - expected[i][c];
          worst = std::max(worst, std::abs(difference));
        }
      }
      ASSERT_LE(worst, 1e-5) << along.x << along.y << along.z;
    }
  }
}

TEST(LineIntegrals, EveryLeafOfTheCondensedOctreeIsVisitedOnce) {
  for (const auto& file : scene_files()) {
    const auto& [folder, scene, cube, reader] = *file;
    const std::int64_t leaves =
        leaf_count(condense<std::int32_t>(cube.values(), scene.size, CondenseOptions{}));
    const DensityClasses classes = identity(*reader);
    for (const Direction& along : {Direction{1, 0, 0}, Direction{0, -1, 1}, Direction{1, 1, -1}}) {
      NoProgress progress;
      const LineView view{0, along, {}};
      EXPECT_EQ(sum_along_lines(*reader, view, classes, emission_of(classes, 1), 1, progress)
                    .counts.leaves,
                leaves);
      EXPECT_EQ(
          average_along_lines(*reader, view, classes, transfer_of(classes), progress).counts.leaves,
          leaves);
    }
  }
}

TEST(LineIntegrals, WhatIsCutAwayGivesNothing) {
  const auto& [folder, scene, cube, reader] = *scene_files()[2];
  const DensityClasses classes = identity(*reader);
  const auto light = emission_of(classes, 1);
  for (const Box& kept : {Box{{3, 0, 9}, {66, 31, 65}}, Box{{64, 64, 0}, {67, 70, 65}}}) {
    NoProgress progress;
    const Direction along{1, -1, 0};
    const LineSums found = sum_along_lines(*reader, {0, along, kept}, classes, light, 1, progress);
    std::vector<std::int64_t> expected(found.sums.size(), 0);
    visit_farthest_first(found.lines, [&, &values = cube](const Index3& v, std::size_t line) {
      if (kept.contains(v)) expected[line] += light[static_cast<std::size_t>(values.at(v))];
    });
    EXPECT_EQ(found.sums, expected);
  }
}

TEST(LineIntegrals, CoarseLevelsAreSummedFromTheirSamples) {
  const auto& reader = scene_files()[4]->reader;
  const DensityClasses classes = identity(*reader);
  const auto light = emission_of(classes, 1);
  for (int level = 1; level < reader->levels().count(); ++level) {
    const Size3 size = reader->levels().size(level);
    const auto samples = testing::read_box(*reader, box_of(size), level);
    NoProgress progress;
    const LineSums found =
        sum_along_lines(*reader, {level, {0, 0, 1}, {}}, classes, light, 1, progress);
    for (std::int64_t i = 0; i < size.x * size.y; ++i) {
      std::int64_t expected = 0;
      for (std::int64_t z = 0; z < size.z; ++z) {
        std::uint16_t value;
        std::memcpy(&value, samples.data() + 2 * (z * size.x * size.y + i), 2);
        expected += light[value];
      }
      ASSERT_EQ(found.sums[static_cast<std::size_t>(i)], expected) << "level " << level;
    }
  }
}

TEST(LineIntegrals, TheNumberOfThreadsChangesNothing) {
  const auto& reader = scene_files().back()->reader;
  const DensityClasses classes = identity(*reader);
  std::vector<LineColor> first;
  for (const int threads : {1, 2}) {
    tbb::task_arena(threads).execute([&] {
      NoProgress progress;
      auto found =
          average_along_lines(*reader, {0, {1, 1, 1}, {}}, classes, transfer_of(classes), progress);
      if (first.empty()) first = std::move(found.colors);
      else EXPECT_EQ(found.colors, first);
    });
  }
}

TEST(LineIntegrals, BricksOfOneRangeAreNotDecoded) {
  const Scene scene{{192, 64, 20}, VoxelType::uint8, {1, 1, 1}, 0};
  const ScratchFolder folder;
  Volume volume;
  volume.description.type = VoxelType::uint8;
  volume.description.size = scene.size;
  std::mt19937 random(3);
  // Noise below 20 in the first brick, below 20 or above 100 in the second, above 100 in the third.
  for (std::int64_t i = 0; i < scene.size.voxel_count(); ++i) {
    const auto brick = i % scene.size.x / 64;
    const auto noise = static_cast<int>(random() % 20);
    const bool is_dense = brick == 2 || (brick == 1 && random() % 2 == 0);
    volume.voxels.push_back(static_cast<std::byte>(is_dense ? 100 + noise : noise));
  }
  testing::build_volume(volume, folder.file("v.8vo"), 2);
  const auto reader = testing::open_file(folder.file("v.8vo"));
  const std::vector<DensityRange> ranges = {{50, 300, {255, 255, 255}, 0.5}};
  const DensityClasses classes = DensityClasses::of_ranges(reader->description(), ranges);
  NoProgress progress;
  const std::vector<std::int32_t> light = {0, 1};
  const LineSums found = sum_along_lines(*reader, {0, {1, 0, 0}, {}}, classes, light, 1, progress);
  EXPECT_EQ(found.counts.decoded_bricks, 1);
  for (const std::int64_t sum : found.sums) EXPECT_TRUE(sum >= 64 && sum <= 128);
}

TEST(LineIntegrals, WrongTablesAndLevelsAreRejected) {
  const auto& reader = scene_files()[1]->reader;
  const DensityClasses classes = identity(*reader);
  NoProgress progress;
  const auto light = emission_of(classes, 1);
  EXPECT_THROW(sum_along_lines(*reader, {99, {1, 0, 0}, {}}, classes, light, 1, progress), Error);
  EXPECT_THROW(sum_along_lines(*reader, {0, {0, 0, 0}, {}}, classes, light, 1, progress), Error);
  EXPECT_THROW(sum_along_lines(*reader, {0, {1, 0, 0}, {}}, classes, light, 2, progress), Error);
  EXPECT_THROW(sum_along_lines(*reader, {0, {1, 0, 0}, {}}, classes, light, 3, progress), Error);
  EXPECT_THROW(average_along_lines(*reader, {0, {1, 0, 0}, {}}, classes, {}, progress), Error);
}

}  // namespace
}  // namespace octavo
