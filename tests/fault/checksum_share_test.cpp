// What checksums add to a file; bench/checksums measures the time they take.
#include <gtest/gtest.h>

#include "octavo/planes/phantom.h"
#include "support/built_file.h"

namespace octavo {
namespace {

using namespace octavo::testing;

// A segment's checksum, and its share of what the index says of it, are 4 bytes; those of pages,
// models and slabs are few.
std::uint64_t checksum_bytes(const FileReader& reader) {
  std::uint64_t bytes = 0;
  for (int tier = 0; tier < reader.levels().tier_count(); ++tier) {
    const Size3 grid = reader.levels().brick_grid(tier);
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const BrickEntry entry =
          reader.brick(tier, {i % grid.x, i / grid.x % grid.y, i / grid.x / grid.y});
      for (const auto& piece : entry.pieces) bytes += piece.length > 0 ? 4 : 0;
    }
  }
  return bytes;
}

TEST(Checksums, AreAtMostAFifthOfAPercentOfTheFile) {
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const ScratchFolder folder;
    const std::string path = folder.file("a.8vo");
    PhantomOptions phantom = phantom_options_for(VoxelType::int16);
    phantom.size = {128, 128, 128};
    phantom.noise_sigma = 12;
    BuildOptions options;
    options.preset = preset;
    NoProgress progress;
    build_file(*make_phantom(phantom), local_storage(), path, options, progress);
    const auto bytes = static_cast<double>(std::filesystem::file_size(path));
    const double share = static_cast<double>(checksum_bytes(*open_file(path))) / bytes;
    std::printf("goal B5: %s: checksums are %.3f %% of the bytes\n",
                preset == Preset::small ? "small" : "fast", 100 * share);
    EXPECT_GT(share, 0);
    EXPECT_LE(share, 0.002);
  }
}

}  // namespace
}  // namespace octavo
