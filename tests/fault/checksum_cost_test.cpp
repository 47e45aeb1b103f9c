// What checksums cost: time beside that of decoding, and bytes of the file.
#include <gtest/gtest.h>

#include <algorithm>
#include <ctime>

#include "octavo/core/crc32c.h"
#include "octavo/planes/phantom.h"
#include "support/built_file.h"
#include "support/goal_cases.h"

namespace octavo {
namespace {

using namespace octavo::testing;

double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) / 1e9;
}

template <class F>
double seconds_of(const F& f) {
  const double began = cpu_seconds();
  f();
  return cpu_seconds() - began;
}

// A segment's checksum, and its share of what the index says of it, are 4 bytes; those of pages,
// models and slabs are few.
std::uint64_t checksum_bytes(const FileReader& reader) {
  std::uint64_t bytes = 0;
  for (int tier = 0; tier < reader.levels().tier_count(); ++tier) {
    const Size3 grid = reader.levels().brick_grid(tier);
    for (std::int64_t i = 0; i < grid.voxel_count(); ++i) {
      const BrickEntry entry =
          reader.brick(tier, {i % grid.x, i / grid.x % grid.y, i / grid.x / grid.y});
      for (const auto& segment : entry.segments) bytes += segment.length > 0 ? 4 : 0;
    }
  }
  return bytes;
}

TEST(ChecksumCost, IsWithinThreePercentOfDecodingAndAFifthOfAPercentOfTheFile) {
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const ScratchFolder folder;
    const std::string path = folder.file("a.8vo");
    PhantomOptions phantom = phantom_options_for(VoxelType::int16);
    const std::int64_t side = is_full_form() ? 256 : 128;
    phantom.size = {side, side, side};
    phantom.noise_sigma = 12;
    BuildOptions options;
    options.preset = preset;
    NoProgress progress;
    build_file(*make_phantom(phantom), local_storage(), path, options, progress);
    const std::string text = bytes_of_file(path);
    const std::vector<std::uint8_t> bytes(text.begin(), text.end());
    ReaderOptions no_cache;
    no_cache.cache_bytes = 0;
    const auto reader = FileReader::open(byte_source_of(bytes, path), no_cache);

    // In turn, and the best of each: what else runs on the machine only ever adds.
    double decoding = 1e9;
    double checking = 1e9;
    GoalCases cases("B5", "interleaved timings", case_count(15, 40));
    while (cases.next()) {
      const Box all = box_of(phantom.size);
      decoding = std::min(decoding, seconds_of([&] { read_box(*reader, all, 0); }));
      checking = std::min(checking, seconds_of([&] {
        volatile std::uint32_t crc = crc32c(bytes);
        static_cast<void>(crc);
      }));
    }
    const double time_share = checking / decoding;
    const double byte_share = static_cast<double>(checksum_bytes(*reader)) /
                              static_cast<double>(bytes.size());
    char figure[160];
    std::snprintf(figure, sizeof figure, "%s: %.2f %% of the time, %.3f %% of the bytes",
                  preset == Preset::small ? "small" : "fast", 100 * time_share, 100 * byte_share);
    cases.tell(figure);
    // A timing holds on a quiet machine alone: the full form judges it, the everyday one shows it.
    if (is_full_form()) EXPECT_LE(time_share, 0.03);
    EXPECT_LE(byte_share, 0.002);
  }
}

}  // namespace
}  // namespace octavo
