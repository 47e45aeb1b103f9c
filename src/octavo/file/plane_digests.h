// The digests of the planes of a volume, from bricks that come row by row.
//
//     plane z    SHA-256 of its voxels, little-endian, row by row, x fastest
//     volume     SHA-256 of the digests of its planes, z = 0 first
//
// A plane meets every brick of its layer. Whole rows of bricks wait in a buffer until none of their
// voxels is missing; then each plane takes its part of them.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"
#include "octavo/file/for_each.h"

namespace octavo {

/// The digest of a volume whose planes have these.
Sha256Digest voxel_digest_of(std::span<const Sha256Digest> planes);

/// Memory  64 MiB, or one row of bricks where that takes more
class PlaneDigests {
 public:
  /// Both references outlive this.
  PlaneDigests(const VolumeDescription& description, const Levels& levels, MakeHasher make_hasher);

  /// Starts with the first row of bricks of a layer of tier 0.
  void begin_layer(std::int64_t layer);

  /// The rows of bricks [lo.y, hi.y) that come next, as a box of bricks of the layer; all of them
  /// are put before add_rows. Empty at the end of the layer.
  Box next_rows() const;

  /// The codes of a brick of these rows, dense [z][y][x]. Several threads may put bricks at a time.
  void put(const Index3& brick, const void* codes);
  /// The same for a brick of one code.
  void put_uniform(const Index3& brick, std::int64_t code);

  /// Hashes the rows that were put.
  void add_rows(const ForEach& for_each);

  /// Those of the layer, by z. Requires that no row is left.
  std::vector<Sha256Digest> digests();

 private:
  void make_room();
  std::uint8_t* row_at(const Box& brick, std::int64_t y, std::int64_t z);

  const VolumeDescription& description_;
  const Levels& levels_;
  MakeHasher make_hasher_;
  std::size_t voxel_bytes_;
  std::int64_t rows_at_once_;  ///< of bricks
  std::int64_t layer_number_ = 0;
  std::int64_t next_row_ = 0;  ///< of bricks
  Box room_;                   ///< in voxels
  Bytes rows_;                 ///< of `room_`, [z][y][x]
  std::vector<std::unique_ptr<Hasher>> hashers_;
};

}  // namespace octavo
