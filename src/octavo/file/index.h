// The index of a .8vo file: where every piece stands, and the range of every brick.
//
// Two storeys. A page describes up to 1024 bricks of one layer of one tier, in o-code order; the
// root describes the pages. Neither holds an offset: pieces stand one after another in the order
// of the index, so that offsets are sums of lengths, and the sums must come out at the offsets in
// the header.
//
//   data = slab 0 .. slab n-1, [model of the other tiers], coarse levels
//   slab = [model] piece 0 of the layer's bricks, slab trailer
//   coarse levels = piece 1 of all bricks of tier 0, piece 2, piece 3; then those of tier 1; ..
//
// Invariants
//   Every page of a layer but the last holds 1024 bricks: the page of a brick is found by division.
// Consequences
//   Pieces cannot overlap, lie outside the data or leave bytes of it to nobody.
//   pages <= layers + bricks / 1024, and a brick costs 2 to 47 bytes of index: the header bounds
//   the index, and what a reader allocates is bounded by the bytes of the file before it allocates.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/levels.h"
#include "octavo/file/index_lengths.h"
#include "octavo/file/layout.h"
#include "octavo/file/pieces.h"

namespace octavo {

/// A page as the root knows it.
struct PageRef {
  std::uint64_t offset = 0;
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
  ValueRange range;                ///< of all its bricks
  std::uint64_t error_steps = 0;   ///< the largest of its bricks
  std::uint32_t uniform_count = 0;
  /// Where the pieces of each number begin; while a file is written, their total length.
  std::array<std::uint64_t, kTierPieces> piece_start{};
};

struct ModelRef {
  std::uint64_t offset = 0;
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
  std::uint32_t first_slab = 0;    ///< the model stands at the start of this slab, or behind all
};

/// The pages of one tier, layer after layer.
struct TierIndex {
  Size3 grid;
  std::int64_t layer_bricks = 0;
  std::int64_t layer_pages = 0;
  std::vector<PageRef> pages;
  std::array<std::uint64_t, kTierPieces> piece_bytes{};
  std::array<std::uint64_t, kTierPieces> piece_end{};
  std::int64_t uniform_count = 0;

  std::int64_t layer_of(std::size_t page) const {
    return static_cast<std::int64_t>(page) / layer_pages;
  }
  /// Place in the layer of a page's first brick, and how many it holds.
  std::int64_t first_place(std::size_t page) const {
    return static_cast<std::int64_t>(page) % layer_pages * kPageBricks;
  }
  std::int64_t brick_count(std::size_t page) const {
    return std::min(kPageBricks, layer_bricks - first_place(page));
  }
};

/// A tier with its grid filled in and no pages.
TierIndex make_tier_index(const Levels& levels, int tier);

struct IndexRoot {
  std::vector<ModelRef> models;
  std::vector<std::uint32_t> slab_trailer_bytes;  ///< one per layer of tier 0
  std::vector<TierIndex> tiers;

  /// The model of a layer of tier 0.
  std::uint32_t model_of_slab(std::int64_t slab) const;
  /// The model of the tiers above tier 0: the one behind the slabs if there is one, else model 0.
  std::uint32_t coarse_model() const;
  /// Where the pieces of a slab end and its trailer begins.
  std::uint64_t slab_trailer_offset(std::int64_t slab) const;
  /// Where pieces number `piece` of a page end.
  std::uint64_t piece_end(int tier, std::size_t page, int piece) const;
  /// Smallest and largest voxel.
  ValueRange range() const;
  /// The largest error of a brick, in steps of the header.
  std::uint64_t error_steps() const;
};

/// Throws Error{corrupt} when the bytes do not describe a tiling of the data of `header`.
IndexRoot parse_root(ByteSpan bytes, const Levels& levels, const FileHeader& header);

/// One piece of a brick.
struct PieceRef {
  std::uint64_t offset = 0;
  std::uint32_t length = 0;
  std::uint32_t crc = 0;
};

/// What a page says of its bricks, in their order.
struct IndexPage {
  int piece_count = 0;
  std::vector<ValueRange> ranges;
  std::vector<std::uint64_t> error_steps;  ///< of tier 0 in lossy files, else empty
  std::vector<std::uint32_t> slots;     ///< number among the bricks that are not uniform
  std::vector<PieceRef> pieces;         ///< [slot][number]

  std::size_t memory_bytes() const {
    return sizeof(IndexPage) + ranges.size() * (sizeof(ValueRange) + sizeof(std::uint32_t)) +
           pieces.size() * sizeof(PieceRef) + error_steps.size() * sizeof(std::uint64_t);
  }
};

/// Page number `page` of `tier`, from its bytes after their checksum was proven.
/// Throws Error{corrupt} when it contradicts the root, the coded type or the max error of `header`;
/// Error{unsupported_version}
IndexPage parse_page(ByteSpan bytes, const IndexRoot& root, const Levels& levels, int tier,
                     std::size_t page, const FileHeader& header);

/// What the errors in the index count, in voxel units: 1 for integer types, a 1024th of the max
/// error for float32.
double error_step(const FileHeader& header);

/// The largest error that may stand in the index, in steps.
std::uint64_t max_error_steps(const FileHeader& header);

/// True when the bricks of a tier have an error in the index: those of tier 0 in a lossy file.
bool has_errors(const FileHeader& header, int tier);

}  // namespace octavo
