// The condensed octree of a file's tones, piece by piece, farthest first.
//
// A piece is either one cube of one tone that the index alone proves, or a block of up to 64^3
// voxels that is to be condensed. Bricks whose least and greatest value have one tone are never
// decoded.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/file/reader.h"
#include "octavo/render/transparency/tone_block.h"
#include "octavo/render/transparency/tones.h"

namespace octavo {

/// A part of the volume: a leaf of `tone`, or a block when `is_leaf` is false.
struct TonePiece {
  Index3 corner;
  std::int64_t side = 0;
  std::int32_t tone = 0;  ///< of a block: -1 where it is not known
  bool is_leaf = false;
};

/// One level of a file as tones. `reader` and `tones` must outlive it.
/// Memory  about 50 bytes per 64^3 voxels
class ToneOctree {
 public:
  /// kept  samples of the level; all outside have tone 0
  /// Throws Error{invalid_argument} when there is no such level, and what the reader throws.
  ToneOctree(const FileReader& reader, int level, const ToneMap& tones, const Box& kept);

  const Size3& size() const { return size_; }

  /// All pieces, in the order of `octants` at every level of the octree.
  std::vector<TonePiece> pieces(const std::array<int, 8>& octants) const;

  /// The part of the volume that a piece covers.
  Box box_of_piece(const TonePiece& piece) const;

  /// Decodes and condenses a block. Thread-safe. Throws what the reader throws.
  /// voxels  room that is used again for the next block
  void load(const TonePiece& piece, ToneBlock& block, std::vector<std::byte>& voxels) const;

  /// Bricks that `load` has decoded.
  std::int64_t decoded_bricks() const { return decoded_; }

 private:
  // The cubes of side 64 * 2^k: the tone of each, or -1.
  struct Floor {
    Size3 grid;
    std::vector<std::int32_t> tones;

    std::size_t place(const Index3& cell) const {
      return static_cast<std::size_t>((cell.z * grid.y + cell.y) * grid.x + cell.x);
    }
  };

  std::int32_t brick_tone(const BrickEntry& entry, const Box& covered) const;
  std::int32_t block_tone(const Index3& block) const;
  Floor floor_above(const Floor& below) const;
  bool is_whole(const Index3& cell, std::int64_t side) const;
  void collect(std::size_t floor, const Index3& cell, const std::array<int, 8>& octants,
               std::vector<TonePiece>& pieces) const;
  template <class Visit>
  void visit_bricks(const Box& box, Visit&& visit) const;

  const FileReader& reader_;
  const ToneMap& tones_;
  int level_;
  Box kept_;
  Size3 size_;
  Size3 brick_side_;  // in samples of the level
  std::vector<Floor> floors_;
  mutable std::atomic<std::int64_t> decoded_ = 0;
};

}  // namespace octavo
