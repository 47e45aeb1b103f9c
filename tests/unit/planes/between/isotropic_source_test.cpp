// Planes between grey slices, and when there are none to make.
#include "octavo/planes/between/isotropic_source.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "octavo/planes/memory_source.h"
#include "support/sought_planes.h"
#include "support/source_files.h"

namespace octavo::testing {
namespace {

using enum PlaneInterpolation;

template <class T>
struct Volume {
  Size3 size;
  Point3 spacing_mm;
  std::vector<T> voxels;
};

template <class T>
VolumeDescription description_of(const Volume<T>& volume) {
  VolumeDescription description;
  description.type = voxel_type_of<T>();
  description.size = volume.size;
  description.geometry.spacing_mm = volume.spacing_mm;
  description.geometry.origin_mm = {5, 6, 7};
  return description;
}

/// The voxels of all planes that are made.
template <class T>
std::vector<T> made_of(const Volume<T>& volume, const VolumeDescription& description,
                       PlaneInterpolation method) {
  const IsotropicPlan plan = plan_isotropic(description, method);
  const auto source = make_isotropic_source(
      make_memory_source(description, std::as_bytes(std::span(volume.voxels))), plan);
  EXPECT_EQ(source->description().size.z, plan.planes);
  const std::string bytes = voxels_of(*source);
  std::vector<T> voxels(bytes.size() / sizeof(T));
  std::memcpy(voxels.data(), bytes.data(), bytes.size());
  return voxels;
}

template <class T>
std::vector<T> made_of(const Volume<T>& volume, PlaneInterpolation method) {
  return made_of(volume, description_of(volume), method);
}

/// A column of single voxels.
template <class T>
Volume<T> column(const std::vector<T>& voxels, double slice_mm) {
  return {{1, 1, static_cast<std::int64_t>(voxels.size())}, {1, 1, slice_mm}, voxels};
}

template <class T>
Volume<T> noise(const Size3& size, const Point3& spacing_mm) {
  Volume<T> volume{size, spacing_mm, {}};
  std::mt19937 numbers(7);
  for (std::int64_t i = 0; i < size.voxel_count(); ++i) {
    volume.voxels.push_back(static_cast<T>(numbers()));
  }
  return volume;
}

TEST(IsotropicSource, ARampStaysExactWithBothMethods) {
  Volume<std::int16_t> ramp{{5, 4, 6}, {0.5, 0.5, 3}, {}};
  std::vector<std::int16_t> expected;
  const auto value_at = [](int x, int y, double slice) {
    return static_cast<std::int16_t>(std::lround(12 * slice + 5 * y + x - 40));
  };
  for (int z = 0; z < 6; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 5; ++x) ramp.voxels.push_back(value_at(x, y, z));
  for (int z = 0; z <= 30; ++z)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 5; ++x) expected.push_back(value_at(x, y, z / 6.0));
  EXPECT_EQ(made_of(ramp, linear), expected);
  EXPECT_EQ(made_of(ramp, cubic), expected);
}

template <class T>
void expect_slices_kept(PlaneInterpolation method) {
  const Volume<T> volume = noise<T>({7, 5, 4}, {0.7, 0.7, 2.1});
  const std::vector<T> planes = made_of(volume, method);
  const std::size_t plane = 7 * 5;
  ASSERT_EQ(planes.size(), plane * 10);
  for (std::size_t z = 0; z < 4; ++z) {
    for (std::size_t i = 0; i < plane; ++i) {
      ASSERT_EQ(planes[3 * z * plane + i], volume.voxels[z * plane + i]) << "slice " << z;
    }
  }
}

TEST(IsotropicSource, SlicesAreKeptBitForBitWhereTheRatioIsWhole) {
  for (const PlaneInterpolation method : {linear, cubic, shape}) {
    expect_slices_kept<std::int8_t>(method);
    expect_slices_kept<std::uint8_t>(method);
    expect_slices_kept<std::int16_t>(method);
    expect_slices_kept<std::uint16_t>(method);
    expect_slices_kept<std::int32_t>(method);
    expect_slices_kept<std::uint32_t>(method);
  }
  expect_slices_kept<float>(linear);
  expect_slices_kept<float>(cubic);
}

TEST(IsotropicSource, PlanesOfABrokenRatioLieAtTheDistanceOfPixels) {
  const Volume<std::int16_t> volume = noise<std::int16_t>({3, 3, 9}, {0.957, 0.957, 1.5});
  const IsotropicPlan plan = plan_isotropic(description_of(volume), linear);
  EXPECT_EQ(plan.planes, 13);
  EXPECT_EQ(plan.made_planes, 12);
  EXPECT_DOUBLE_EQ(plan.plane_mm, 0.957);
  EXPECT_NEAR(plan.left_out_mm, 8 * 1.5 - 12 * 0.957, 1e-9);
  EXPECT_NE(plan.notice.find("hold no plane"), std::string::npos);
  const std::vector<std::int16_t> planes = made_of(volume, linear);
  for (std::size_t z = 0; z < 13; ++z) {
    const double height = static_cast<double>(z) * 0.957 / 1.5;
    const auto below = static_cast<std::size_t>(height);
    for (std::size_t i = 0; i < 9; ++i) {
      const double a = volume.voxels[below * 9 + i];
      const double b = below + 1 < 9 ? volume.voxels[(below + 1) * 9 + i] : a;
      const double part = height - static_cast<double>(below);
      EXPECT_NEAR(planes[z * 9 + i], (1 - part) * a + part * b, 0.5001);
    }
  }
}

TEST(IsotropicSource, TheLastSliceIsAPlaneWhereItFallsOnTheGrid) {
  const Volume<std::uint8_t> volume = column<std::uint8_t>({0, 0, 90}, 1.5);
  const std::vector<std::uint8_t> expected = {0, 0, 30, 90};
  EXPECT_EQ(made_of(volume, linear), expected);
  EXPECT_EQ(plan_isotropic(description_of(volume), linear).left_out_mm, 0);
}

TEST(IsotropicSource, HalvesAreRoundedUp) {
  const auto volume = column<std::int16_t>({0, 1, 0, -1, -2}, 2);
  const std::vector<std::int16_t> expected = {0, 1, 1, 1, 0, 0, -1, -1, -2};
  EXPECT_EQ(made_of(volume, linear), expected);
}

TEST(IsotropicSource, CubicIsExactForParabolasAwayFromTheEnds) {
  std::vector<float> voxels;
  for (int z = 0; z < 7; ++z) voxels.push_back(static_cast<float>(16 * z * z - 32 * z + 3));
  const std::vector<float> planes = made_of(column(voxels, 4), cubic);
  ASSERT_EQ(planes.size(), 25U);
  for (int k = 4; k <= 20; ++k) {
    EXPECT_EQ(planes[static_cast<std::size_t>(k)], static_cast<float>(k * k - 8 * k + 3));
  }
}

TEST(IsotropicSource, CubicOvershootsByAnEighthAtMostAndStaysInItsType) {
  const auto bytes = made_of(column<std::uint8_t>({0, 255, 255, 0, 0, 255}, 2), cubic);
  EXPECT_EQ(bytes[3], 255);
  EXPECT_EQ(bytes[7], 0);
  const auto wide = made_of(column<std::int16_t>({0, 800, 800, 0, 0, 800}, 2), cubic);
  EXPECT_EQ(wide[3], 900);
  EXPECT_EQ(wide[7], -100);
  const auto limits = made_of(
      column<std::int32_t>({std::numeric_limits<std::int32_t>::min(),
                            std::numeric_limits<std::int32_t>::max(),
                            std::numeric_limits<std::int32_t>::max(),
                            std::numeric_limits<std::int32_t>::min()}, 2), cubic);
  EXPECT_EQ(limits[3], std::numeric_limits<std::int32_t>::max());
}

TEST(IsotropicSource, WhatIsNoMeasurementIsNotMixed) {
  auto volume = column<std::int16_t>({-2000, 100, 200}, 4);
  VolumeDescription description = description_of(volume);
  description.padding = -2000;
  const std::vector<std::int16_t> expected = {-2000, -2000, 100, 100, 100, 125, 150, 175, 200};
  EXPECT_EQ(made_of(volume, description, linear), expected);

  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const auto floats = made_of(column<float>({nan, 1, 3, inf}, 4), linear);
  EXPECT_TRUE(std::isnan(floats[1]));
  EXPECT_EQ(floats[2], 1);
  EXPECT_EQ(floats[6], 2);
  EXPECT_EQ(floats[9], 3);
  EXPECT_EQ(floats[10], inf);
}

TEST(IsotropicSource, PlaceAndMetadataAreThoseOfTheSource) {
  const Volume<std::int16_t> volume = noise<std::int16_t>({3, 3, 4}, {0.5, 0.5, 2});
  VolumeDescription description = description_of(volume);
  description.rescale = {2, -1024};
  description.metadata = Metadata::read(R"({"unit":"HU","prepared":{"dropped_duplicates":1}})");
  const IsotropicPlan plan = plan_isotropic(description, cubic);
  const auto source = make_isotropic_source(
      make_memory_source(description, std::as_bytes(std::span(volume.voxels))), plan);
  const VolumeDescription& made = source->description();
  EXPECT_EQ(made.geometry.origin_mm, description.geometry.origin_mm);
  EXPECT_EQ(made.geometry.spacing_mm, (Point3{0.5, 0.5, 0.5}));
  EXPECT_EQ(made.rescale, description.rescale);
  const auto metadata = nlohmann::json::parse(made.metadata.text());
  EXPECT_EQ(metadata["unit"], "HU");
  EXPECT_EQ(metadata["prepared"]["dropped_duplicates"], 1);
  const nlohmann::json expected = {{"method", "cubic"}, {"slices", 4}, {"slice_mm", 2.0},
                                   {"step_mm", 0.5}, {"made_plane_count", 9}};
  EXPECT_EQ(metadata["prepared"]["isotropic"], expected);
}

/// The metadata behind --isotropic of 4 slices that become 13 planes.
nlohmann::json metadata_behind(const std::string& before, PlaneInterpolation method) {
  const Volume<std::int16_t> volume = noise<std::int16_t>({3, 3, 4}, {0.5, 0.5, 2});
  VolumeDescription description = description_of(volume);
  description.metadata = Metadata::read(before);
  const auto source = make_isotropic_source(
      make_memory_source(description, std::as_bytes(std::span(volume.voxels))),
      plan_isotropic(description, method));
  return nlohmann::json::parse(source->description().metadata.text());
}

TEST(IsotropicSource, NumbersOfSlicesInTheMetadataBecomeThoseOfPlanes) {
  const std::string before = R"({"prepared":{"gaps":{"made_planes":[[0,0],[3,3]]}},)"
                             R"("repaired":{"missing_planes":[3,3],"fill":7}})";
  const nlohmann::json lines = metadata_behind(before, linear);
  EXPECT_EQ(lines["prepared"]["gaps"]["made_planes"], nlohmann::json({{0, 3}, {9, 12}}));
  EXPECT_EQ(lines["repaired"], nlohmann::json({{"missing_planes", {9, 12}}, {"fill", 7}}));
  const nlohmann::json curves = metadata_behind(before, cubic);
  EXPECT_EQ(curves["prepared"]["gaps"]["made_planes"],
            nlohmann::json({{0, 3}, {5, 7}, {9, 12}}));
  EXPECT_EQ(curves["repaired"]["missing_planes"], nlohmann::json({5, 12}));
}

TEST(IsotropicSource, MetadataOfAnyShapeAreTaken) {
  for (const char* before :
       {R"({"prepared":5})", R"({"prepared":{"gaps":[1],"x":1}})", R"({"prepared":null})",
        R"({"prepared":{"gaps":{"made_planes":[[2,1]]}}})", R"({"repaired":[]})",
        R"({"prepared":{"gaps":{"made_planes":[[0,4],["a",1]]}}})",
        R"({"repaired":{"missing_planes":[0,18446744073709551615]}})"}) {
    const nlohmann::json after = metadata_behind(before, linear);
    EXPECT_EQ(after["prepared"]["isotropic"]["slices"], 4) << before;
    EXPECT_FALSE(after.contains("repaired")) << before;
    EXPECT_EQ(after.dump().find("made_planes"), std::string::npos) << before;
  }
}

TEST(IsotropicSource, PlanesAreTheSameFromAnywhere) {
  // Slices a whole number of pixels apart, and not; few values make shapes.
  for (const double slice_mm : {3.0, 1.7, 1.25}) {
    for (const PlaneInterpolation method : {linear, cubic, shape}) {
      Volume<std::uint8_t> volume = noise<std::uint8_t>({9, 7, 6}, {1, 1, slice_mm});
      for (std::uint8_t& voxel : volume.voxels) voxel = static_cast<std::uint8_t>(voxel % 3);
      const VolumeDescription description = description_of(volume);
      const auto source = make_isotropic_source(
          make_memory_source(description, std::as_bytes(std::span(volume.voxels))),
          plan_isotropic(description, method));
      SCOPED_TRACE(std::string(interpolation_name(method)) + " " + std::to_string(slice_mm));
      EXPECT_TRUE(source->can_seek());
      const std::int64_t count = source->description().size.z;
      const auto all = planes_between(*source, 0, count);
      for (std::int64_t first = 0; first < count; ++first) {
        for (std::int64_t end = first; end <= count; ++end) {
          const auto planes = planes_between(*source, first, end);
          ASSERT_TRUE(std::equal(planes.begin(), planes.end(), all.begin() + first)) << first;
        }
      }
      expect_same_from_anywhere(*source);
    }
  }
}

/// Counts the slices that were read.
class CountedSource final : public PlaneSource {
 public:
  CountedSource(VolumeDescription description, std::int64_t& count)
      : description_(std::move(description)), count_(count) {}
  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  void read_plane(std::span<std::byte> plane) override {
    std::fill(plane.begin(), plane.end(), std::byte{1});
    ++count_;
  }
  void seek(std::int64_t first, std::int64_t end) override { sought_ = {first, end}; }
  std::pair<std::int64_t, std::int64_t> sought() const { return sought_; }

 private:
  VolumeDescription description_;
  std::vector<Warning> warnings_;
  std::int64_t& count_;
  std::pair<std::int64_t, std::int64_t> sought_;
};

TEST(IsotropicSource, NoSliceIsSoughtThatTakesNoPart) {
  const struct {
    PlaneInterpolation method;
    std::int64_t first, end;
    std::pair<std::int64_t, std::int64_t> slices;
  } table[] = {{linear, 0, 5, {0, 2}},    {linear, 5, 6, {1, 2}},     {linear, 21, 26, {4, 6}},
               {cubic, 0, 5, {0, 3}},     {cubic, 21, 24, {3, 7}},    {cubic, 20, 26, {3, 7}},
               {shape, 21, 25, {4, 6}},   {linear, 241, 246, {48, 50}}, {linear, 7, 7, {0, 0}}};
  for (const auto& [method, first, end, slices] : table) {
    const Volume<std::uint8_t> volume{{4, 4, 50}, {1, 1, 5}, {}};
    std::int64_t count = 0;
    auto counted = std::make_unique<CountedSource>(description_of(volume), count);
    const CountedSource& inner = *counted;
    const auto source = make_isotropic_source(std::move(counted),
                                              plan_isotropic(description_of(volume), method));
    source->seek(first, end);
    EXPECT_EQ(inner.sought(), slices) << interpolation_name(method) << first;
    std::vector<std::byte> plane(16);
    for (std::int64_t z = first; z < end; ++z) source->read_plane(plane);
    EXPECT_LE(count, slices.second - slices.first) << interpolation_name(method) << first;
  }
}

TEST(IsotropicSource, NoSliceIsReadBeforeItTakesPart) {
  for (const PlaneInterpolation method : {linear, cubic, shape}) {
    const Volume<std::uint8_t> volume{{4, 4, 50}, {1, 1, 5}, {}};
    std::int64_t count = 0;
    const IsotropicPlan plan = plan_isotropic(description_of(volume), method);
    const auto source = make_isotropic_source(
        std::make_unique<CountedSource>(description_of(volume), count), plan);
    std::vector<std::byte> plane(16);
    for (std::int64_t z = 0; z < plan.planes; ++z) {
      source->read_plane(plane);
      EXPECT_LE(count, z / 5 + (method == cubic ? 3 : 2)) << interpolation_name(method) << z;
    }
    EXPECT_EQ(count, 50);
    EXPECT_THROW(source->read_plane(plane), Error);
  }
}

TEST(IsotropicPlanning, NothingIsDoneWhereThereIsNothingToMake) {
  const struct {
    Size3 size;
    Point3 spacing_mm;
    const char* words;
  } table[] = {{{4, 4, 9}, {1, 1, 1}, "cubes already"},
               {{4, 4, 9}, {1, 1, 1.0009}, "cubes already"},
               {{4, 4, 9}, {0.8, 0.8, 0.5}, "closer than the pixels"},
               {{4, 4, 1}, {0.5, 0.5, 9}, "single slice"}};
  for (const auto& [size, spacing_mm, words] : table) {
    const Volume<std::uint8_t> volume{size, spacing_mm, {}};
    const IsotropicPlan plan = plan_isotropic(description_of(volume), linear);
    EXPECT_FALSE(plan.is_needed) << words;
    EXPECT_NE(plan.notice.find(words), std::string::npos) << plan.notice;
  }
}

TEST(IsotropicPlanning, WhatCannotBecomeCubesIsRejectedWithItsReason) {
  const Volume<std::uint8_t> volume{{4, 4, 9}, {1, 1, 3}, {}};
  VolumeDescription unknown = description_of(volume);
  unknown.metadata = Metadata::read(R"({"spacing_known":false})");
  VolumeDescription oblong = description_of(volume);
  oblong.geometry.spacing_mm = {0.5, 7, 9};
  VolumeDescription far = description_of(volume);
  far.geometry.spacing_mm = {0.01, 0.01, 3};
  VolumeDescription many = description_of(volume);
  many.size.z = std::int64_t{1} << 20;
  const struct {
    VolumeDescription description;
    ErrorKind kind;
    const char* words;
  } table[] = {{unknown, ErrorKind::invalid_argument, "[spacing_mm]"},
               {oblong, ErrorKind::source_rejected, "0.5 x 7 x 9 mm"},
               {far, ErrorKind::source_rejected, "300 pixels apart"},
               {many, ErrorKind::limit_exceeded, ""}};
  for (const auto& [description, kind, words] : table) {
    const Error error = error_of([&] { plan_isotropic(description, linear); });
    EXPECT_EQ(error.kind(), kind) << words;
    EXPECT_NE(with_hints(error).find(words), std::string::npos) << with_hints(error);
  }
  VolumeDescription floats = description_of(volume);
  floats.type = VoxelType::float32;
  EXPECT_EQ(error_of([&] { plan_isotropic(floats, shape); }).kind(), ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace octavo::testing
