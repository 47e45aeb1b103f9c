// Builds volumes of every sort and prints the CRC-32C of each file: what must be the same for any
// number of threads, any instruction set and any compiler.
//
// usage: file_hashes THREADS [STEP]   prints "NAME: BYTES CRC", of every STEP-th volume
//        file_hashes --levels         prints the values of OCTAVO_SIMD that this machine has
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/codec/simd_level.h"
#include "octavo/core/crc32c.h"
#include "octavo/planes/memory_source.h"
#include "support/memory_storage.h"

namespace octavo {
namespace {

struct Sample {
  const char* name;
  Size3 size;
  VoxelType type = VoxelType::uint8;
  VolumeKind kind = VolumeKind::grey;
  Preset preset = Preset::small;
  double max_error = 0;
  double slice_mm = 1;
};

constexpr auto kLabels = VolumeKind::labels;
constexpr auto kFast = Preset::fast;

const Sample kSamples[] = {
    {.name = "voxel", .size = {1, 1, 1}},
    {.name = "row", .size = {131, 1, 1}, .type = VoxelType::int16},
    {.name = "column", .size = {1, 97, 1}, .type = VoxelType::uint16},
    {.name = "stick", .size = {1, 1, 67}, .type = VoxelType::int32},
    {.name = "primes", .size = {67, 43, 37}, .type = VoxelType::int16},
    {.name = "bricks", .size = {65, 66, 67}, .type = VoxelType::uint8},
    {.name = "signed bytes", .size = {64, 32, 16}, .type = VoxelType::int8},
    {.name = "words", .size = {31, 64, 33}, .type = VoxelType::uint16},
    {.name = "wide", .size = {40, 30, 20}, .type = VoxelType::uint32},
    {.name = "thick slices", .size = {66, 66, 9}, .type = VoxelType::int16, .slice_mm = 5},
    {.name = "fast bytes", .size = {67, 43, 37}, .type = VoxelType::uint8, .preset = kFast},
    {.name = "fast words", .size = {65, 66, 17}, .type = VoxelType::int16, .preset = kFast},
    {.name = "within 1", .size = {64, 64, 32}, .type = VoxelType::int16, .max_error = 1},
    {.name = "within 20", .size = {64, 50, 32}, .type = VoxelType::int16, .max_error = 20},
    {.name = "fast within 4", .size = {64, 50, 32}, .type = VoxelType::uint8, .preset = kFast,
     .max_error = 4},
    {.name = "floats", .size = {33, 34, 35}, .type = VoxelType::float32},
    {.name = "floats within 0.5", .size = {33, 64, 35}, .type = VoxelType::float32,
     .max_error = 0.5},
    {.name = "labels", .size = {66, 65, 20}, .type = VoxelType::uint8, .kind = kLabels},
    {.name = "many labels", .size = {40, 41, 42}, .type = VoxelType::uint16, .kind = kLabels},
    {.name = "wide labels", .size = {30, 31, 32}, .type = VoxelType::uint32, .kind = kLabels}};

// Smooth ground with edges and noise; regions for labels. Integers alone decide the voxels.
template <class T>
std::vector<T> voxels_of(const Sample& sample) {
  std::vector<T> voxels;
  std::mt19937_64 random(static_cast<std::uint64_t>(sample.size.voxel_count()));
  for (std::int64_t z = 0; z < sample.size.z; ++z) {
    for (std::int64_t y = 0; y < sample.size.y; ++y) {
      for (std::int64_t x = 0; x < sample.size.x; ++x) {
        const std::int64_t region = (x / 9 + y / 13 + z / 7) % 5;
        const std::int64_t smooth = (3 * x + 2 * y + z) / 8 + 20 * region;
        const auto noise = static_cast<std::int64_t>(random() % 8);
        const bool is_label = sample.kind == VolumeKind::labels;
        voxels.push_back(static_cast<T>(is_label ? region * region : smooth % 100 + noise));
      }
    }
  }
  return voxels;
}

void print_hash(const Sample& sample, int threads) {
  VolumeDescription description;
  description.kind = sample.kind;
  description.type = sample.type;
  description.size = sample.size;
  description.geometry.spacing_mm = {1, 1, sample.slice_mm};
  BuildOptions options;
  options.kind = sample.kind;
  options.preset = sample.preset;
  options.max_error = sample.max_error;
  options.threads = threads;
  testing::MemoryStorage storage;
  with_voxel_type(sample.type, [&](auto id) {
    const auto voxels = voxels_of<typename decltype(id)::type>(sample);
    NoProgress progress;
    build_file(*make_memory_source(description, std::as_bytes(std::span(voxels))), storage,
               "a.8vo", options, progress);
  });
  const auto& bytes = *storage.files.at("a.8vo");
  std::printf("%s: %zu %08x\n", sample.name, bytes.size(), crc32c(bytes));
}

}  // namespace
}  // namespace octavo

int main(int count, char** arguments) {
  try {
    if (count > 1 && std::strcmp(arguments[1], "--levels") == 0) {
      std::puts("scalar");
      for (const char* level : {"sse4", "avx2", "avx512", "neon", "wasm"}) {
        if (octavo::simd_targets_of(level) != 0) std::puts(level);
      }
      return 0;
    }
    const int threads = count > 1 ? std::atoi(arguments[1]) : 0;
    const int step = count > 2 ? std::atoi(arguments[2]) : 1;
    if (threads < 1 || step < 1) {
      std::fputs("usage: file_hashes THREADS [STEP] | --levels\n", stderr);
      return 2;
    }
    for (std::size_t i = 0; i < std::size(octavo::kSamples); i += static_cast<std::size_t>(step)) {
      octavo::print_hash(octavo::kSamples[i], threads);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "file_hashes: %s\n", error.what());
    return 1;
  }
}
