// Builds in bands of bricks, for groups that memory does not hold.
#include "octavo/builder/band_reader.h"

#include <gtest/gtest.h>

#include <cstring>

#include "octavo/builder/build_memory.h"
#include "octavo/builder/builder.h"
#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/planes/computed_source.h"
#include "support/goal_cases.h"
#include "support/hints.h"
#include "support/memory_storage.h"
#include "support/stopping_progress.h"

namespace octavo {
namespace {

using testing::MemoryStorage;

constexpr Size3 kSize{80, 140, 150};
constexpr std::uint64_t kBrickBytes = 64 * 64 * 64 * 2;

/// A texture in some bricks, one value in others.
std::unique_ptr<PlaneSource> source_of(VoxelType type, VolumeKind kind = VolumeKind::grey) {
  VolumeDescription description;
  description.type = type;
  description.kind = kind;
  description.size = kSize;
  const auto fill = [type, kind](const Box& box, std::byte* voxels) {
    with_voxel_type(type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      auto* out = reinterpret_cast<T*>(voxels);
      for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
        for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
          for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
            const auto noise = static_cast<std::uint32_t>(x * 7 + y * 131 + z * 977) * 2654435761u;
            std::int64_t value = y < 64 ? 9 : (x + y + 2 * z) / 8 % 90 + (noise >> 30);
            if (kind == VolumeKind::labels) value /= 20;
            *out++ = static_cast<T>(x >= 64 && x < 128 && y >= 128 ? 3 : value);
          }
        }
      }
    });
  };
  return make_computed_source(description, fill, 4);
}

std::vector<std::uint8_t> built(PlaneSource& source, BuildOptions options) {
  MemoryStorage storage;
  NoProgress progress;
  options.kind = source.description().kind;
  options.threads = 3;
  const BuildResult result = build_file(source, storage, "a.8vo", options, progress);
  EXPECT_EQ(result.is_in_bands, options.band_bytes > 0 || options.max_memory_bytes > 0);
  EXPECT_GT(result.read_seconds, 0);
  EXPECT_LE(result.read_seconds, result.total_seconds);
  EXPECT_EQ(storage.files.size(), 1u);
  return *storage.files.at("a.8vo");
}

TEST(BandReader, BandsOfAnySizeGiveTheFileOfWholeGroups) {
  const SmallGroups small(std::uint64_t{5} << 18);
  struct Case {
    VoxelType type;
    VolumeKind kind;
    BuildOptions options;
  };
  const BuildOptions fast = {.preset = Preset::fast};
  for (const Case& one :
       {Case{VoxelType::uint16, VolumeKind::grey, {}},
        Case{VoxelType::int32, VolumeKind::grey, fast},
        Case{VoxelType::float32, VolumeKind::grey, {}},
        Case{VoxelType::uint8, VolumeKind::labels, {}},
        Case{VoxelType::uint16, VolumeKind::grey, {.max_error = 2}},
        Case{VoxelType::uint8, VolumeKind::grey, {.preset = Preset::fast, .keep_details = 2}},
        Case{VoxelType::float32, VolumeKind::grey, {.preset = Preset::fast, .max_error = 1.5}}}) {
    const auto source = source_of(one.type, one.kind);
    const std::vector<std::uint8_t> whole = built(*source, one.options);
    BuildOptions options = one.options;
    std::vector<std::uint64_t> sizes = {2 * kBrickBytes + 1};
    if (testing::is_full_form() || one.options.preset == Preset::fast) {
      sizes.insert(sizes.end(), {1, 1000 * kBrickBytes});
    }
    for (const std::uint64_t bytes : sizes) {
      source->seek(0, kSize.z);
      options.band_bytes = bytes;
      EXPECT_TRUE(built(*source, options) == whole)
          << voxel_type_name(one.type) << " within " << options.max_error << ", " << bytes;
    }
  }
}

TEST(BandReader, UniformBricksTakeNoRoom) {
  const auto source = source_of(VoxelType::uint16);
  const Levels levels(kSize, choose_halvings(kSize, {1, 1, 1}));
  NoProgress progress;
  BandReader bands(*source, levels, 0, kSize.z, {kBrickBytes}, progress);
  std::size_t bricks = 0;
  while (!bands.is_done()) {
    const BrickBand& band = bands.next();
    EXPECT_EQ(band.first, bricks);
    bricks += band.bricks.size();
    std::size_t bytes = 0;
    for (const auto& voxels : band.voxels) bytes += voxels.size() > 128 ? voxels.size() : 0;
    EXPECT_LE(bytes, kBrickBytes);
  }
  EXPECT_EQ(bricks, static_cast<std::size_t>(levels.brick_count(0)));
}

class FromItsStart final : public PlaneSource {
 public:
  explicit FromItsStart(std::unique_ptr<PlaneSource> source) : source_(std::move(source)) {}
  const VolumeDescription& description() const override { return source_->description(); }
  const std::vector<Warning>& warnings() const override { return source_->warnings(); }
  void read_plane(std::span<std::byte> plane) override { source_->read_plane(plane); }
  bool can_seek() const override { return false; }
  void seek(std::int64_t first, std::int64_t end) override { source_->seek(first, end); }

 private:
  std::unique_ptr<PlaneSource> source_;
};

VolumeDescription wide_planes(VoxelType type) {
  VolumeDescription description;
  description.type = type;
  description.size = {1024, 1024, 80};
  return description;
}

std::string failure_of(PlaneSource& source, const BuildOptions& options) {
  MemoryStorage storage;
  NoProgress progress;
  try {
    build_file(source, storage, "a.8vo", options, progress);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::limit_exceeded);
    return error.what();
  }
  return "it was built";
}

TEST(BandReader, ALimitBelowWholeGroupsMakesBandsOrSaysWhyNot) {
  const auto fill = [](const Box& box, std::byte* voxels) {
    const auto bytes = static_cast<std::size_t>(box.size().voxel_count());
    std::memset(voxels, 0, 2 * bytes);
    for (std::size_t i = 0; i < 70000; ++i) voxels[2 * i] = static_cast<std::byte>(i % 97);
  };
  const VolumeDescription grey = wide_planes(VoxelType::uint16);
  const std::uint64_t whole = build_memory_bytes(grey, 1);
  const std::uint64_t bands = band_memory_bytes(grey, 1, std::uint64_t{16} << 20);
  const auto source = make_computed_source(grey, fill, 1);
  const std::uint64_t held = source->resident_bytes();
  ASSERT_LT(bands, whole);
  MemoryStorage storage;
  NoProgress progress;
  const auto is_in_bands = [&](std::uint64_t limit) {
    source->seek(0, grey.size.z);
    return build_file(*source, storage, "a.8vo",
                      {.preset = Preset::fast,
                       .overwrite = true,
                       .threads = 1,
                       .max_memory_bytes = limit},
                      progress)
        .is_in_bands;
  };
  EXPECT_FALSE(is_in_bands(whole + held));
  const std::vector<std::uint8_t> file = *storage.files.at("a.8vo");
  EXPECT_TRUE(is_in_bands(whole + held - 1));
  EXPECT_TRUE(*storage.files.at("a.8vo") == file);
  EXPECT_TRUE(is_in_bands(bands + held));
  EXPECT_TRUE(*storage.files.at("a.8vo") == file);

  const BuildOptions little = {.threads = 1, .max_memory_bytes = bands + held - 1};
  EXPECT_NE(failure_of(*source, little).find("MiB of memory"), std::string::npos);
  const BuildOptions enough = {.threads = 1, .max_memory_bytes = bands + held};
  FromItsStart once(make_computed_source(grey, fill, 1));
  EXPECT_NE(failure_of(once, enough).find("can only be read from its start on"),
            std::string::npos);
}

TEST(BandReader, AnInterruptedBuildGoesOnInBandsOrWithoutThem) {
  const SmallGroups small(std::uint64_t{5} << 18);
  const auto source = source_of(VoxelType::uint16);
  const std::vector<std::uint8_t> whole = built(*source, {.preset = Preset::fast});
  for (const std::uint64_t before : {std::uint64_t{0}, 3 * kBrickBytes}) {
    MemoryStorage storage;
    testing::StoppingProgress stopping(before == 0 ? 145 : 240);
    BuildOptions options = {.preset = Preset::fast,
                            .interrupted = Interrupted::resume,
                            .band_bytes = before};
    source->seek(0, kSize.z);
    EXPECT_THROW(build_file(*source, storage, "a.8vo", options, stopping), Error);
    options.band_bytes = 3 * kBrickBytes - before;
    source->seek(0, kSize.z);
    NoProgress progress;
    EXPECT_GT(build_file(*source, storage, "a.8vo", options, progress).resumed_planes, 0);
    EXPECT_TRUE(*storage.files.at("a.8vo") == whole) << before;
  }
}

}  // namespace
}  // namespace octavo
