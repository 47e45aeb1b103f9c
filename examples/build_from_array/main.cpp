// Builds an .8vo file from voxels in memory: a ball of 1000 HU in air, 64^3 voxels of 0.5 mm.
//
// usage: build_from_array FILE.8vo
#include <cstdint>
#include <iostream>
#include <span>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/core/error.h"
#include "octavo/core/metadata.h"
#include "octavo/file/storage/storage.h"
#include "octavo/planes/memory_source.h"

namespace {

constexpr std::int64_t kSide = 64;

/// Voxels in the order that every volume has: [z][y][x], x fastest.
std::vector<std::int16_t> ball() {
  constexpr std::int64_t kRadius = 24;
  const auto squared = [](std::int64_t at) { return (at - kSide / 2) * (at - kSide / 2); };
  std::vector<std::int16_t> voxels;
  for (std::int64_t z = 0; z < kSide; ++z) {
    for (std::int64_t y = 0; y < kSide; ++y) {
      for (std::int64_t x = 0; x < kSide; ++x) {
        const bool is_inside = squared(x) + squared(y) + squared(z) < kRadius * kRadius;
        voxels.push_back(is_inside ? 1000 : -1000);
      }
    }
  }
  return voxels;
}

octavo::VolumeDescription description() {
  octavo::MetadataFacts facts;
  facts.unit = "HU";
  facts.spacing_known = true;
  octavo::VolumeDescription volume;
  volume.type = octavo::VoxelType::int16;
  volume.size = {kSide, kSide, kSide};
  volume.geometry.spacing_mm = {0.5, 0.5, 0.5};
  volume.metadata = octavo::Metadata::of(facts);
  return volume;
}

void build(const std::string& path) {
  const std::vector<std::int16_t> voxels = ball();
  const auto source =
      octavo::make_memory_source(description(), std::as_bytes(std::span(voxels)));
  octavo::BuildOptions options;
  options.overwrite = true;
  octavo::NoProgress progress;
  const octavo::BuildResult result =
      octavo::build_file(*source, octavo::local_storage(), path, options, progress);
  std::cout << result.raw_bytes << " bytes of voxels in a file of " << result.file_bytes << "\n";
}

}  // namespace

int main(int count, char** words) {
  if (count != 2) {
    std::cerr << "usage: build_from_array FILE.8vo\n";
    return 2;
  }
  try {
    build(words[1]);
    return 0;
  } catch (const octavo::Error& error) {
    std::cerr << "build_from_array: " << error.what() << "\n";
    return 1;
  }
}
