#include "octavo/ops/measure/measure.h"

#include <gtest/gtest.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <sstream>

#include "octavo/core/error.h"
#include "support/built_file.h"

namespace octavo {
namespace {

struct Scene {
  Size3 size;
  std::vector<std::int16_t> labels;
  std::vector<std::int16_t> grey;

  std::int64_t label_at(const Index3& p) const {
    if (!box_of(size).contains(p)) return -1;
    return labels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
  }
};

template <class F>
void for_each_voxel(const Size3& size, F f) {
  std::size_t i = 0;
  for (std::int64_t z = 0; z < size.z; ++z)
    for (std::int64_t y = 0; y < size.y; ++y)
      for (std::int64_t x = 0; x < size.x; ++x) f(Index3{x, y, z}, i++);
}

// A slab that fills whole bricks, balls, single voxels, a negative and a large label.
Scene make_scene() {
  Scene scene{{200, 150, 140}, {}, {}};
  std::mt19937 random(1);
  for_each_voxel(scene.size, [&](const Index3& p, std::size_t) {
    std::int16_t label = p.x >= 64 ? 3 : 0;
    if (std::hypot(p.x - 60, p.y - 40, p.z - 30) < 25) label = 7;
    if (std::hypot(p.x - 30, p.y - 90, p.z - 100) < 20) label = -2;
    if (random() % 4000 == 0) label = 30000;
    scene.labels.push_back(label);
    const auto noise = static_cast<std::int64_t>(random() % 50);
    scene.grey.push_back(static_cast<std::int16_t>(label / 10 + 20 * (p.z % 9) + noise));
  });
  return scene;
}

std::string built(const testing::ScratchFolder& folder, const Size3& size, VoxelType type,
                  const void* voxels, VolumeKind kind, const std::string& name,
                  double max_error_of_floats = 1e-3) {
  VolumeDescription description;
  description.size = size;
  description.type = type;
  const auto bytes = static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(type));
  NoProgress progress;
  BuildOptions options;
  options.kind = kind;
  if (type == VoxelType::float32) options.max_error = max_error_of_floats;
  build_file(*make_memory_source(description, {static_cast<const std::byte*>(voxels), bytes}),
             local_storage(), folder.file(name), options, progress);
  return folder.file(name);
}

class MeasuredScene : public testing::ScratchFolder {
 public:
  MeasuredScene() : scene(make_scene()) {
    const auto file = [&](const std::vector<std::int16_t>& voxels, VolumeKind kind,
                          const char* name) {
      return testing::open_file(
          built(*this, scene.size, VoxelType::int16, voxels.data(), kind, name));
    };
    labels = file(scene.labels, VolumeKind::labels, "labels.8vo");
    grey = file(scene.grey, VolumeKind::grey, "grey.8vo");
  }

  Scene scene;
  std::shared_ptr<FileReader> labels;
  std::shared_ptr<FileReader> grey;
};

const MeasuredScene& measured() {
  static const MeasuredScene scene;
  return scene;
}

/// Every number with all its digits; NaN is NaN.
std::string digits_of(const RegionMeasure& region) {
  std::ostringstream text;
  text << std::hexfloat << region.label << ' ' << region.voxel_count << ' '
       << region.surface_voxel_count;
  for (int axis = 0; axis < 3; ++axis) text << ' ' << region.box.lo[axis] << region.box.hi[axis];
  for (const double number : region.centroid) text << ' ' << number;
  for (const double number : region.covariance) text << ' ' << number;
  if (!region.grey) return text.str();
  const GreyStatistics& grey = *region.grey;
  text << " grey " << grey.not_finite << ' ' << grey.mean << ' ' << grey.deviation << ' '
       << grey.minimum << ' ' << grey.maximum << ' ' << grey.sum;
  for (const double number : grey.percentiles) text << ' ' << number;
  return text.str();
}

/// Parts of any number, joined, give every digit of one measurement.
void expect_same_in_parts(const FileReader& labels, const FileReader* grey,
                          const RegionMeasureOptions& options) {
  NoProgress progress;
  const auto whole = measure_regions(labels, grey, options, progress);
  for (const std::int64_t count : {1, 2, 3, 8}) {
    SCOPED_TRACE(count);
    PartOfRegions all;
    for (std::int64_t number = 0; number < count; ++number) {
      add_part(measure_part(labels, grey, options, {number, count}, progress), all);
    }
    const auto joined = joined_regions(all, grey, options);
    ASSERT_EQ(joined.size(), whole.size());
    for (std::size_t i = 0; i < whole.size(); ++i) {
      EXPECT_EQ(digits_of(joined[i]), digits_of(whole[i]));
    }
  }
}

TEST(MeasureRegions, AgreesWithEveryVoxel) {
  const Scene& scene = measured().scene;
  NoProgress progress;
  const auto regions = measure_regions(*measured().labels, measured().grey.get(), {}, progress);
  std::map<std::int64_t, std::vector<Index3>> expected;
  std::map<std::int64_t, std::vector<double>> values;
  std::map<std::int64_t, std::uint64_t> surface;
  for_each_voxel(scene.size, [&](const Index3& p, std::size_t i) {
    const std::int64_t label = scene.labels[i];
    if (label == 0) return;
    expected[label].push_back(p);
    values[label].push_back(scene.grey[i]);
    const Index3 beside[] = {{p.x - 1, p.y, p.z}, {p.x + 1, p.y, p.z}, {p.x, p.y - 1, p.z},
                             {p.x, p.y + 1, p.z}, {p.x, p.y, p.z - 1}, {p.x, p.y, p.z + 1}};
    surface[label] += std::any_of(std::begin(beside), std::end(beside), [&](const Index3& q) {
      return scene.label_at(q) != label;
    });
  });
  ASSERT_EQ(regions.size(), expected.size());
  auto region = regions.begin();
  for (auto& [label, voxels] : expected) {
    SCOPED_TRACE(label);
    EXPECT_EQ(region->label, label);
    EXPECT_EQ(region->voxel_count, voxels.size());
    EXPECT_EQ(region->surface_voxel_count, surface[label]);
    const auto n = static_cast<double>(voxels.size());
    std::array<double, 3> mean{};
    Box box{voxels.front(), voxels.front()};
    for (const Index3& p : voxels) {
      for (int axis = 0; axis < 3; ++axis) {
        mean[static_cast<std::size_t>(axis)] += static_cast<double>(p[axis]) / n;
        box.lo[axis] = std::min(box.lo[axis], p[axis]);
        box.hi[axis] = std::max(box.hi[axis], p[axis] + 1);
      }
    }
    EXPECT_EQ(region->box, box);
    std::array<double, 6> covariance{};
    for (const Index3& p : voxels) {
      const double d[3] = {static_cast<double>(p.x) - mean[0], static_cast<double>(p.y) - mean[1],
                           static_cast<double>(p.z) - mean[2]};
      const double products[6] = {d[0] * d[0], d[1] * d[1], d[2] * d[2],
                                  d[0] * d[1], d[0] * d[2], d[1] * d[2]};
      for (std::size_t i = 0; i < 6; ++i) covariance[i] += products[i] / n;
    }
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(region->centroid[i], mean[i], 1e-9);
    for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(region->covariance[i], covariance[i], 1e-6);

    std::vector<double>& v = values[label];
    std::sort(v.begin(), v.end());
    double sum = 0;
    for (const double value : v) sum += value;
    double squares = 0;
    for (const double value : v) squares += (value - sum / n) * (value - sum / n);
    ASSERT_TRUE(region->grey.has_value());
    EXPECT_EQ(region->grey->sum, sum);
    EXPECT_EQ(region->grey->minimum, v.front());
    EXPECT_EQ(region->grey->maximum, v.back());
    EXPECT_NEAR(region->grey->mean, sum / n, 1e-9);
    EXPECT_NEAR(region->grey->deviation, std::sqrt(squares / n), 1e-6);
    const double percents[] = {5, 25, 50, 75, 95};
    for (std::size_t i = 0; i < 5; ++i) {
      const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(percents[i] * n / 100)));
      EXPECT_EQ(region->grey->percentiles[i], v[rank - 1]) << percents[i];
    }
    ++region;
  }
}

TEST(MeasureRegions, CountsTheBorderOfTheVolumeAsSurfaceForEveryLabel) {
  const Size3 size{5, 4, 3};
  const testing::ScratchFolder folder;
  for (const std::int16_t label : std::initializer_list<std::int16_t>{-1, 1, -32768}) {
    const std::vector<std::int16_t> labels(static_cast<std::size_t>(size.voxel_count()), label);
    const std::string name = std::to_string(label) + ".8vo";
    const auto file = testing::open_file(
        built(folder, size, VoxelType::int16, labels.data(), VolumeKind::labels, name));
    NoProgress progress;
    const auto regions = measure_regions(*file, nullptr, {}, progress);
    ASSERT_EQ(regions.size(), 1u);
    EXPECT_EQ(regions[0].voxel_count, 60u);
    EXPECT_EQ(regions[0].surface_voxel_count, 60u - 3 * 2 * 1);
  }
}

TEST(MeasureRegions, TakesFloats) {
  const Scene& scene = measured().scene;
  std::vector<float> values;
  for (const std::int16_t v : scene.grey) values.push_back(1e4f + static_cast<float>(v) / 64);
  const testing::ScratchFolder folder;
  const auto floats = testing::open_file(built(folder, scene.size, VoxelType::float32,
                                               values.data(), VolumeKind::grey, "f.8vo"));
  NoProgress progress;
  const auto of_floats = measure_regions(*measured().labels, floats.get(), {}, progress);
  const auto of_grey = measure_regions(*measured().labels, measured().grey.get(), {}, progress);
  ASSERT_EQ(of_floats.size(), of_grey.size());
  for (std::size_t i = 0; i < of_grey.size(); ++i) {
    EXPECT_NEAR(of_floats[i].grey->mean, 1e4 + of_grey[i].grey->mean / 64, 2e-3);
    EXPECT_NEAR(of_floats[i].grey->deviation, of_grey[i].grey->deviation / 64, 2e-3);
    EXPECT_NEAR(of_floats[i].grey->percentiles[2], 1e4 + of_grey[i].grey->percentiles[2] / 64,
                2e-3);
  }
}

// Rows of labels 1 and 2 in several bricks, and the voxel (0, 0, 0) outside both.
struct FloatRows {
  Size3 size{70, 66, 2};
  std::vector<std::uint8_t> labels;
  std::vector<float> values;

  explicit FloatRows(const std::function<float(std::uint8_t label)>& value_of) {
    for_each_voxel(size, [&](const Index3& p, std::size_t i) {
      labels.push_back(i == 0 ? 0 : p.y % 2 == 0 ? 1 : 2);
      values.push_back(value_of(labels.back()));
    });
  }

  std::vector<RegionMeasure> measured() const {
    const testing::ScratchFolder folder;
    const auto mask = testing::open_file(
        built(folder, size, VoxelType::uint8, labels.data(), VolumeKind::labels, "l.8vo"));
    const auto grey = testing::open_file(
        built(folder, size, VoxelType::float32, values.data(), VolumeKind::grey, "g.8vo", 0));
    NoProgress progress;
    return measure_regions(*mask, grey.get(), {}, progress);
  }

  void expect_statistics(const RegionMeasure& region) const {
    SCOPED_TRACE(region.label);
    std::vector<long double> of_label;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (labels[i] == region.label) of_label.push_back(values[i]);
    }
    const auto count = static_cast<long double>(of_label.size());
    const long double sum = std::accumulate(of_label.begin(), of_label.end(), 0.0L);
    long double squares = 0;
    for (const long double v : of_label) squares += (v - sum / count) * (v - sum / count);
    const auto deviation = static_cast<double>(std::sqrt(squares / count));
    EXPECT_DOUBLE_EQ(region.grey->mean, static_cast<double>(sum / count));
    EXPECT_DOUBLE_EQ(region.grey->sum, static_cast<double>(sum));
    EXPECT_NEAR(region.grey->deviation, deviation, 1e-12 * deviation);
  }
};

TEST(MeasureRegions, AFloatFarOffElsewhereChangesNoNumberOfARegion) {
  std::mt19937 random(3);
  std::normal_distribution<float> noise(0, 1);
  for (const float around : {100.0f, -1e6f}) {
    for (const float outside : {-FLT_MAX, FLT_MAX}) {
      const FloatRows rows([&](std::uint8_t label) {
        return label == 0 ? outside : around + static_cast<float>(label) * noise(random);
      });
      const auto regions = rows.measured();
      ASSERT_EQ(regions.size(), 2u);
      for (const RegionMeasure& region : regions) rows.expect_statistics(region);
    }
  }
}

TEST(MeasureRegions, AFloatFarOffInsideARegionEntersItsNumbers) {
  std::uint32_t n = 0;
  const FloatRows rows([&](std::uint8_t) { return ++n == 3000 ? -FLT_MAX : 8.0f; });
  for (const RegionMeasure& region : rows.measured()) rows.expect_statistics(region);
}

TEST(MeasureRegions, SeesASmallSpreadOfLargeIntegers) {
  const Size3 size{40, 8, 8};
  const testing::ScratchFolder folder;
  std::vector<std::uint32_t> values;
  std::vector<std::uint8_t> labels;
  for_each_voxel(size, [&](const Index3& p, std::size_t i) {
    labels.push_back(p.x < 8 ? 0 : p.x < 24 ? 1 : 2);
    const std::uint32_t odd = i % 2;
    values.push_back(labels[i] == 0 ? 0 : labels[i] == 1 ? 4000000000u + odd : 4294967295u * odd);
  });
  const auto mask = testing::open_file(
      built(folder, size, VoxelType::uint8, labels.data(), VolumeKind::labels, "l.8vo"));
  const auto grey = testing::open_file(
      built(folder, size, VoxelType::uint32, values.data(), VolumeKind::grey, "g.8vo"));
  NoProgress progress;
  const auto regions = measure_regions(*mask, grey.get(), {}, progress);
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[0].grey->mean, 4000000000.5);
  EXPECT_EQ(regions[0].grey->deviation, 0.5);
  EXPECT_EQ(regions[1].grey->mean, 2147483647.5);
  EXPECT_EQ(regions[1].grey->deviation, 2147483647.5);
}

TEST(MeasureRegions, WhatHasNoFiniteVoxelHasNoNumbers) {
  const FloatRows rows([](std::uint8_t label) {
    return label == 2 ? std::nanf("") : label == 1 ? 3.0f : -FLT_MAX;
  });
  const auto regions = rows.measured();
  ASSERT_EQ(regions.size(), 2u);
  EXPECT_EQ(regions[0].grey->not_finite, 0u);
  EXPECT_EQ(regions[0].grey->percentiles, std::vector<double>(5, 3.0));
  const GreyStatistics& none = *regions[1].grey;
  EXPECT_EQ(none.not_finite, regions[1].voxel_count);
  for (const double number : {none.mean, none.deviation, none.minimum, none.maximum, none.sum}) {
    EXPECT_TRUE(std::isnan(number));
  }
  ASSERT_EQ(none.percentiles.size(), 5u);
  for (const double number : none.percentiles) EXPECT_TRUE(std::isnan(number));
}

/// Whether percentiles of a volume of type T are values of it, at the ranks that they say.
template <class T>
void expect_exact_percentiles(VoxelType type, const std::function<T(std::uint32_t)>& value_of) {
  const Size3 size{67, 65, 9};
  const testing::ScratchFolder folder;
  std::vector<T> values;
  std::vector<std::uint8_t> labels;
  std::uint32_t state = 11;
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    state = state * 1664525u + 1013904223u;
    values.push_back(value_of(state >> 8));
    labels.push_back(static_cast<std::uint8_t>(i % 5 == 0 ? i % 3 : i / size.x % 4));
  }
  const auto mask = testing::open_file(
      built(folder, size, VoxelType::uint8, labels.data(), VolumeKind::labels, "l.8vo"));
  const auto grey =
      testing::open_file(built(folder, size, type, values.data(), VolumeKind::grey, "g.8vo"));
  grey->read(box_of(size), 0, values.data());  // floats are built within an error
  RegionMeasureOptions options;
  options.percentiles = {0, 0.01, 5, 37.5, 50, 99.99, 100};
  for (const bool falls : {false, true}) {
    options.falls = falls;
    NoProgress progress;
    const auto regions = measure_regions(*mask, grey.get(), options, progress);
    if (sizeof(T) == 2) expect_same_in_parts(*mask, grey.get(), options);
    ASSERT_EQ(regions.size(), 3u);
    for (const RegionMeasure& region : regions) {
      std::vector<T> sorted;
      for (std::size_t i = 0; i < values.size(); ++i) {
        if (labels[i] == region.label) sorted.push_back(values[i]);
      }
      std::sort(sorted.begin(), sorted.end());
      if (falls) std::reverse(sorted.begin(), sorted.end());
      for (std::size_t i = 0; i < options.percentiles.size(); ++i) {
        const double share = options.percentiles[i] * static_cast<double>(sorted.size()) / 100;
        const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(share)));
        EXPECT_EQ(region.grey->percentiles[i], static_cast<double>(sorted[rank - 1]))
            << options.percentiles[i] << " of label " << region.label << (falls ? " falling" : "");
      }
    }
  }
}

TEST(MeasureRegions, PercentilesAreValuesThatOccurHoweverFarTheyLieApart) {
  expect_exact_percentiles<std::uint16_t>(
      VoxelType::uint16, [](std::uint32_t n) { return static_cast<std::uint16_t>(n); });
  expect_exact_percentiles<std::int16_t>(
      VoxelType::int16, [](std::uint32_t n) { return static_cast<std::int16_t>(n); });
  expect_exact_percentiles<std::int32_t>(VoxelType::int32, [](std::uint32_t n) {
    return n % 977 == 0 ? 2000000000 : static_cast<std::int32_t>(n % 1000) - 500;
  });
  expect_exact_percentiles<std::uint32_t>(
      VoxelType::uint32, [](std::uint32_t n) { return n % 7 * 613566756u + n % 3; });
  expect_exact_percentiles<float>(VoxelType::float32, [](std::uint32_t n) {
    return n % 4999 == 0 ? 4096.0f : static_cast<float>(n % 1000) / 8 - 60;
  });
}

TEST(MeasureRegions, WholePercentsOfAHundredVoxelsAreTheVoxelsOfThatRank) {
  const Size3 size{100, 1, 1};
  std::vector<std::uint8_t> values(100);
  std::iota(values.begin(), values.end(), std::uint8_t{0});
  const std::vector<std::uint8_t> labels(100, 1);
  const testing::ScratchFolder folder;
  const auto mask = testing::open_file(
      built(folder, size, VoxelType::uint8, labels.data(), VolumeKind::labels, "l.8vo"));
  const auto grey = testing::open_file(
      built(folder, size, VoxelType::uint8, values.data(), VolumeKind::grey, "g.8vo"));
  RegionMeasureOptions options;
  options.percentiles.resize(100);
  std::iota(options.percentiles.begin(), options.percentiles.end(), 1.0);
  NoProgress progress;
  const auto regions = measure_regions(*mask, grey.get(), options, progress);
  const std::vector<double> expected(values.begin(), values.end());
  EXPECT_EQ(regions.at(0).grey->percentiles, expected);
}

TEST(MeasureRegions, DoNotDependOnTheThreads) {
  std::vector<std::vector<RegionMeasure>> all;
  for (const int threads : {1, 3}) {
    tbb::task_arena(threads).execute([&] {
      NoProgress progress;
      all.push_back(measure_regions(*measured().labels, measured().grey.get(), {}, progress));
    });
  }
  ASSERT_EQ(all[0].size(), all[1].size());
  for (std::size_t i = 0; i < all[0].size(); ++i) {
    EXPECT_EQ(all[0][i].covariance, all[1][i].covariance);
    EXPECT_EQ(all[0][i].grey->deviation, all[1][i].grey->deviation);
  }
}

TEST(MeasureRegions, DoNotDependOnTheParts) {
  const MeasuredScene& files = measured();
  expect_same_in_parts(*files.labels, files.grey.get(), {});
  expect_same_in_parts(*files.labels, files.grey.get(), {{1, 50}, true, {3, 7, 30000}});
  expect_same_in_parts(*files.labels, nullptr, {});
}

/// With differences between floats that a sum in floating point loses.
TEST(MeasureRegions, OfFloatsDoNotDependOnTheParts) {
  const Size3 size{30, 20, 200};
  std::vector<std::uint8_t> labels;
  std::vector<float> values;
  std::mt19937 random(4);
  for_each_voxel(size, [&](const Index3& p, std::size_t i) {
    labels.push_back(static_cast<std::uint8_t>((p.x / 7 + p.z / 50) % 3));
    const auto value = static_cast<float>(random() % 1000);
    values.push_back(i % 50 == 0 ? 1e20f * value : i % 3 == 0 ? -1e-20f * value : value);
  });
  values[77] = std::nanf("");
  const testing::ScratchFolder folder;
  const auto mask = testing::open_file(
      built(folder, size, VoxelType::uint8, labels.data(), VolumeKind::labels, "l.8vo"));
  const auto floats = testing::open_file(
      built(folder, size, VoxelType::float32, values.data(), VolumeKind::grey, "f.8vo", 0));
  ASSERT_GT(mask->levels().brick_grid(0).z, 2);
  expect_same_in_parts(*mask, floats.get(), {{}, false, {}});
  NoProgress progress;
  try {
    measure_part(*mask, floats.get(), {}, {0, 2}, progress);
    ADD_FAILURE() << "percentiles of wide floats in parts";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::invalid_argument);
    EXPECT_EQ(error.field(), "percentiles");
  }
}

TEST(MeasureRegions, RejectsWhatItCannotMeasure) {
  NoProgress progress;
  EXPECT_THROW(measure_regions(*measured().grey, nullptr, {}, progress), Error);
  const testing::ScratchFolder folder;
  const std::vector<std::uint8_t> small(27);
  const auto other = testing::open_file(built(folder, {3, 3, 3}, VoxelType::uint8, small.data(),
                                              VolumeKind::grey, "s.8vo"));
  EXPECT_THROW(measure_regions(*measured().labels, other.get(), {}, progress), Error);
}

TEST(PrincipalAxes, AreThoseOfAnEllipsoidTurnedInSpace) {
  RegionMeasure region;
  region.covariance = {4, 9, 1, 0, 0, 0};
  Geometry geometry;
  geometry.spacing_mm = {1, 2, 3};
  const double c = std::cos(0.3);
  const double s = std::sin(0.3);
  geometry.direction = {c, -s, 0, s, c, 0, 0, 0, 1};
  const PrincipalAxes axes = principal_axes(region, geometry);
  EXPECT_NEAR(axes.moments_mm2[0], 36, 1e-9);
  EXPECT_NEAR(axes.moments_mm2[1], 9, 1e-9);
  EXPECT_NEAR(axes.moments_mm2[2], 4, 1e-9);
  EXPECT_NEAR(axes.axes[0][0], -s, 1e-9);
  EXPECT_NEAR(axes.axes[0][1], c, 1e-9);
  EXPECT_NEAR(axes.axes[1][2], 1, 1e-9);
  EXPECT_NEAR(axes.axes[2][0], c, 1e-9);
}

}  // namespace
}  // namespace octavo
