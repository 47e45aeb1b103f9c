#include "octavo/planes/phantom.h"

#include <gtest/gtest.h>

#include <cmath>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "support/sought_planes.h"

namespace octavo {
namespace {

template <class T>
std::vector<T> voxels_of(const PhantomOptions& options) {
  const auto source = make_phantom(options);
  const auto plane = static_cast<std::size_t>(options.size.x * options.size.y);
  std::vector<T> voxels(plane * static_cast<std::size_t>(options.size.z));
  for (std::size_t offset = 0; offset < voxels.size(); offset += plane) {
    source->read_plane(std::as_writable_bytes(std::span(voxels).subspan(offset, plane)));
  }
  return voxels;
}

PhantomOptions small_phantom(double sigma) {
  PhantomOptions options;
  options.size = {40, 44, 48};
  options.noise_sigma = sigma;
  return options;
}

std::int16_t at(const std::vector<std::int16_t>& voxels, const Size3& size, const Index3& p) {
  return voxels[static_cast<std::size_t>((p.z * size.y + p.y) * size.x + p.x)];
}

TEST(Phantom, EveryRegionHasItsDensity) {
  const PhantomOptions options = small_phantom(0);
  const auto voxels = voxels_of<std::int16_t>(options);
  const Size3& size = options.size;
  EXPECT_EQ(at(voxels, size, {0, 0, 0}), -1000);
  EXPECT_EQ(at(voxels, size, {20, 22, 7}), 900);
  EXPECT_EQ(at(voxels, size, {20, 22, 24}), 40);
  EXPECT_EQ(at(voxels, size, {13, 19, 24}), 300);
  EXPECT_EQ(at(voxels, size, {26, 22, 24}), -100);
}

TEST(Phantom, PlanesAreTheSameFromAnywhere) {
  testing::expect_same_from_anywhere(*make_phantom(small_phantom(5)));
}

TEST(Phantom, ShellHasTheVolumeOfTwoSpheres) {
  PhantomOptions options;
  options.size = {128, 128, 128};
  const auto voxels = voxels_of<std::int16_t>(options);
  const auto count = static_cast<double>(std::count(voxels.begin(), voxels.end(), 900));
  const double expected = 4.0 / 3 * M_PI * (std::pow(0.9 * 64, 3) - std::pow(0.8 * 64, 3));
  EXPECT_NEAR(count / expected, 1, 0.005);
}

TEST(Phantom, ShapesAreRoundInMillimetersWhateverTheSpacing) {
  PhantomOptions options = small_phantom(0);
  options.size = {40, 40, 20};
  options.spacing_mm = {1, 1, 2};
  const auto voxels = voxels_of<std::int16_t>(options);
  const double shortest = 20;
  for (std::int64_t z = 0; z < 20; ++z) {
    const double z_mm = (static_cast<double>(z) - 9.5) * 2;
    const double from_center = std::hypot(z_mm, 0.5, 0.5);
    const bool is_outside = from_center > 0.9 * shortest;
    EXPECT_EQ(at(voxels, options.size, {20, 20, z}) == -1000, is_outside) << z;
  }
  EXPECT_EQ(make_phantom(options)->description().geometry.spacing_mm, options.spacing_mm);
}

TEST(Phantom, NoiseDependsOnSeedAndPositionAlone) {
  const PhantomOptions quiet = small_phantom(0);
  PhantomOptions noisy = small_phantom(12);
  noisy.seed = 77;
  const auto a = voxels_of<std::int16_t>(quiet);
  const auto b = voxels_of<std::int16_t>(noisy);
  const Size3& size = quiet.size;
  for (const Index3 p :
       {Index3{0, 0, 0}, Index3{39, 43, 47}, Index3{20, 22, 24}, Index3{3, 41, 9}}) {
    EXPECT_EQ(at(b, size, p), std::lround(at(a, size, p) + 12 * phantom_noise(77, p)));
  }
  EXPECT_EQ(voxels_of<std::int16_t>(noisy), b);
  noisy.seed = 78;
  EXPECT_NE(voxels_of<std::int16_t>(noisy), b);
}

TEST(Phantom, NoiseHasMeanZeroAndVarianceOne) {
  double sum = 0;
  double squares = 0;
  double products = 0;
  double before = 0;
  const int side = 64;
  for (int z = 0; z < side; ++z)
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const double noise = phantom_noise(1, {x, y, z});
        EXPECT_LE(std::abs(noise), 6);
        sum += noise;
        squares += noise * noise;
        products += noise * before;
        before = noise;
      }
  const double count = std::pow(side, 3);
  EXPECT_NEAR(sum / count, 0, 0.01);
  EXPECT_NEAR(squares / count, 1, 0.01);
  EXPECT_NEAR(products / count, 0, 0.01);
}

// The checksum is that of the voxels on any machine.
TEST(Phantom, VoxelsAreTheSameOnEveryMachine) {
  const auto voxels = voxels_of<std::int16_t>(small_phantom(12));
  const auto bytes = std::as_bytes(std::span(voxels));
  EXPECT_EQ(crc32c({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}),
            0xb3298821u);
}

TEST(Phantom, DensitiesAreClampedToTheType) {
  PhantomOptions options = small_phantom(12);
  options.type = VoxelType::uint8;
  const auto bytes = voxels_of<std::uint8_t>(options);
  EXPECT_EQ(bytes.front(), 0);
  EXPECT_EQ(*std::max_element(bytes.begin(), bytes.end()), 255);
  options.type = VoxelType::int8;
  const auto signed_bytes = voxels_of<std::int8_t>(options);
  EXPECT_EQ(signed_bytes.front(), -128);
  EXPECT_EQ(*std::max_element(signed_bytes.begin(), signed_bytes.end()), 127);
}

TEST(Phantom, EveryTypeHasFiveDistinctDensities) {
  for (const VoxelType type :
       {VoxelType::int8, VoxelType::uint8, VoxelType::int16, VoxelType::uint16}) {
    const PhantomOptions o = phantom_options_for(type);
    const ValueRange range = value_range(type);
    std::vector<double> densities = {o.background, o.shell, o.inside, o.first_cylinder,
                                     o.second_cylinder};
    std::sort(densities.begin(), densities.end());
    EXPECT_EQ(std::unique(densities.begin(), densities.end()), densities.end());
    EXPECT_GE(densities.front(), static_cast<double>(range.min));
    EXPECT_LE(densities.back(), static_cast<double>(range.max));
  }
}

TEST(Phantom, BadOptionsAreRejected) {
  const auto rejected = [](auto change) {
    PhantomOptions options = small_phantom(0);
    change(options);
    EXPECT_THROW(make_phantom(options), Error);
  };
  rejected([](PhantomOptions& o) { o.size.y = 0; });
  rejected([](PhantomOptions& o) { o.type = VoxelType::int32; });
  rejected([](PhantomOptions& o) { o.type = VoxelType::float32; });
  rejected([](PhantomOptions& o) { o.inner_radius = 0.9; });
  rejected([](PhantomOptions& o) { o.outer_radius = 1.1; });
  rejected([](PhantomOptions& o) { o.inner_radius = std::nan(""); });
  rejected([](PhantomOptions& o) { o.noise_sigma = -1; });
  rejected([](PhantomOptions& o) { o.noise_sigma = std::nan(""); });
  rejected([](PhantomOptions& o) { o.spacing_mm[2] = 0; });
  rejected([](PhantomOptions& o) { o.shell = INFINITY; });
}

TEST(Phantom, NoPlaneIsGivenBeyondTheLast) {
  PhantomOptions options;
  options.size = {2, 2, 1};
  const auto source = make_phantom(options);
  std::vector<std::byte> plane(8);
  source->read_plane(plane);
  EXPECT_THROW(source->read_plane(plane), Error);
}

}  // namespace
}  // namespace octavo
