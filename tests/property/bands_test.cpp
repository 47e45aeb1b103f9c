// Plans and parts of groups that memory does not hold.
#include <gtest/gtest.h>

#include <cstring>

#include "octavo/builder/build_memory.h"
#include "octavo/builder/group_reader.h"
#include "octavo/core/error.h"
#include "octavo/dist/parts.h"
#include "octavo/dist/plan_text.h"
#include "octavo/planes/computed_source.h"
#include "support/memory_storage.h"
#include "support/part_volumes.h"

namespace octavo::testing {
namespace {

TEST(Bands, APlanInBandsIsThatOfWholeGroups) {
  const SmallGroups groups(kPartGroupBytes);
  for (const SmallVolume& volume : part_volumes()) {
    SmallVolume in_bands = volume;
    for (const std::uint64_t bytes : {1u, 1u << 13, 1u << 20}) {
      in_bands.options.band_bytes = bytes;
      EXPECT_EQ(plan_text(planned(in_bands)), plan_text(planned(volume))) << volume.name;
    }
  }
}

/// Planes of which a group takes more memory than bands of it.
std::unique_ptr<PlaneSource> wide_planes() {
  VolumeDescription volume;
  volume.type = VoxelType::uint16;
  volume.size = {2048, 2048, 130};
  const auto fill = [](const Box& box, std::byte* voxels) {
    const auto bytes = static_cast<std::size_t>(box.size().voxel_count());
    std::memset(voxels, 0, 2 * bytes);
    for (std::size_t i = 0; i < 70000; ++i) voxels[2 * i] = static_cast<std::byte>(i % 97);
  };
  return make_computed_source(volume, fill, 1);
}

ErrorKind failure_of(PlaneSource& source, const BuildPlan& plan, Storage& storage,
                     std::uint64_t limit) {
  NoProgress progress;
  try {
    build_part(plan, source, 1, 2, storage, "small", {.threads = 1, .max_memory_bytes = limit},
               progress);
  } catch (const Error& error) {
    return error.kind();
  }
  return ErrorKind::internal;
}

TEST(Bands, ALimitBelowWholeGroupsMakesTheSamePlanAndParts) {
  const auto source = wide_planes();
  const VolumeDescription& volume = source->description();
  const std::uint64_t held = source->resident_bytes();
  const std::uint64_t whole = build_memory_bytes(volume, 1) + held;
  const std::uint64_t bands = band_memory_bytes(volume, 1, std::uint64_t{16} << 20) + held;
  ASSERT_LT(bands, whole);
  NoProgress progress;
  MemoryStorage storage;
  BuildOptions options = {.preset = Preset::fast, .threads = 1};
  const BuildPlan plan = plan_build(*source, options, progress);
  options.max_memory_bytes = bands;
  EXPECT_EQ(plan_text(plan_build(*wide_planes(), options, progress)), plan_text(plan));
  for (const std::uint64_t limit : {whole, bands}) {
    build_part(plan, *wide_planes(), 1, 2, storage, "part-" + std::to_string(limit),
               {.threads = 1, .max_memory_bytes = limit}, progress);
  }
  EXPECT_TRUE(*storage.files.at("part-" + std::to_string(whole)) ==
              *storage.files.at("part-" + std::to_string(bands)));
  options.max_memory_bytes = bands - 1;
  EXPECT_THROW(plan_build(*wide_planes(), options, progress), Error);
  EXPECT_EQ(failure_of(*wide_planes(), plan, storage, bands - 1), ErrorKind::limit_exceeded);
  EXPECT_EQ(storage.files.size(), 2u);
}

}  // namespace
}  // namespace octavo::testing
