#include "octavo/file/index_lengths.h"

#include <algorithm>

namespace octavo {

namespace {

// A brick in its page: two varints; with a max error a third; of each of 4 pieces a length of up to
// 4 bytes and a CRC.
constexpr std::uint64_t kMinBrickBytes = 2;
constexpr std::uint64_t kMaxBrickBytes = 3 * 5 + 4 * (4 + 4);

// In the root: a page with its length, CRC, range, error, uniform count and 4 totals; a layer of
// tier 0 with its slab trailer and a model; the number of models, and one model more.
constexpr std::uint64_t kMaxPageRefBytes = 3 + 4 + 3 * 5 + 2 + 4 * 5;
constexpr std::uint64_t kMaxSlabRefBytes = 16;
constexpr std::uint64_t kMaxRootHeadBytes = 16;

// A slab trailer: magic, build id, slab and model, a length a brick, a digest a plane, three
// numbers at its end.
constexpr std::uint64_t kMaxTrailerFrameBytes = 30;
constexpr std::uint64_t kMaxTrailerBrickBytes = 4;
constexpr std::uint64_t kTrailerPlaneBytes = 32;
constexpr std::uint64_t kMaxTrailerBytes = std::uint64_t{1} << 30;

struct Counts {
  std::uint64_t bricks = 0;
  std::uint64_t pages = 0;
};

// No sum below overflows: a brick of a tier below the last covers 64 samples or more, so that there
// are fewer than 2^58 bricks.
Counts counts_of(const Levels& levels) {
  Counts all;
  for (int tier = 0; tier < levels.tier_count(); ++tier) {
    const Size3 grid = levels.brick_grid(tier);
    all.bricks += static_cast<std::uint64_t>(grid.voxel_count());
    all.pages +=
        static_cast<std::uint64_t>((grid.x * grid.y + kPageBricks - 1) / kPageBricks * grid.z);
  }
  return all;
}

LengthBounds lengths_of(const Counts& counts) {
  return {counts.pages + kMinBrickBytes * counts.bricks,
          counts.pages + kMaxBrickBytes * counts.bricks};
}

}  // namespace

LengthBounds page_lengths(std::int64_t bricks) {
  return lengths_of({static_cast<std::uint64_t>(bricks), 1});
}

LengthBounds pages_lengths(const Levels& levels) { return lengths_of(counts_of(levels)); }

LengthBounds root_lengths(const Levels& levels) {
  const std::uint64_t pages = counts_of(levels).pages;
  const auto slabs = static_cast<std::uint64_t>(levels.brick_grid(0).z);
  return {slabs + kMinPageRefBytes * pages,
          kMaxRootHeadBytes + kMaxSlabRefBytes * slabs + kMaxPageRefBytes * pages};
}

std::uint64_t max_slab_trailer_bytes(std::int64_t bricks, std::int64_t planes) {
  return std::min(kMaxTrailerBytes,
                  kMaxTrailerFrameBytes +
                      kMaxTrailerBrickBytes * static_cast<std::uint64_t>(bricks) +
                      kTrailerPlaneBytes * static_cast<std::uint64_t>(planes));
}

}  // namespace octavo
