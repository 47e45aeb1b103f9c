// The condensed octree of a file's classes, piece by piece, farthest first.
//
// A piece is either one cube of one class that the index alone proves, or a block of up to 64^3
// voxels that is to be condensed. Bricks whose minimum and maximum value have one class are never
// decoded.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/file/reader.h"
#include "octavo/render/transparency/class_block.h"
#include "octavo/render/transparency/density_classes.h"

namespace octavo {

/// A part of the volume: a leaf of `class`, or a block when `is_leaf` is false.
struct ClassPiece {
  Index3 corner;
  std::int64_t side = 0;
  std::int32_t class_id = 0;  ///< of a block: -1 where it is not known
  bool is_leaf = false;
};

/// One level of a file as classes. `reader` and `classes` must outlive it.
/// Memory  about 50 bytes per 64^3 voxels
class ClassOctree {
 public:
  /// kept  samples of the level; all outside have class 0
  /// Throws Error{invalid_argument} when there is no such level, and what the reader throws.
  ClassOctree(const FileReader& reader, int level, const DensityClasses& classes, const Box& kept);

  const Size3& size() const { return size_; }

  /// All pieces, in the order of `octants` at every level of the octree.
  std::vector<ClassPiece> pieces(const std::array<int, 8>& octants) const;

  /// The part of the volume that a piece covers.
  Box box_of_piece(const ClassPiece& piece) const;

  /// Decodes and condenses a block. Thread-safe. Throws what the reader throws.
  /// voxels  room that is used again for the next block
  void load(const ClassPiece& piece, ClassBlock& block, std::vector<std::byte>& voxels) const;

  /// Bricks that `load` has decoded.
  std::int64_t decoded_bricks() const { return decoded_; }

 private:
  // The cubes of side 64 * 2^k: the class of each, or -1.
  struct Floor {
    Size3 grid;
    std::vector<std::int32_t> classes;

    std::size_t place(const Index3& cell) const {
      return static_cast<std::size_t>((cell.z * grid.y + cell.y) * grid.x + cell.x);
    }
  };

  std::int32_t brick_class(const BrickEntry& entry, const Box& covered) const;
  std::int32_t block_class(const Index3& block) const;
  Floor floor_above(const Floor& below) const;
  bool is_whole(const Index3& cell, std::int64_t side) const;
  void collect(std::size_t floor, const Index3& cell, const std::array<int, 8>& octants,
               std::vector<ClassPiece>& pieces) const;
  template <class Visit>
  void visit_bricks(const Box& box, Visit&& visit) const;

  const FileReader& reader_;
  const DensityClasses& classes_;
  int level_;
  Box kept_;
  Size3 size_;
  Size3 brick_side_;  // in samples of the level
  std::vector<Floor> floors_;
  mutable std::atomic<std::int64_t> decoded_ = 0;
};

}  // namespace octavo
