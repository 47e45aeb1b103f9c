// The digests of the planes of a volume, from bricks that come row by row.
//
//     plane z    SHA-256 of its voxels, little-endian, row by row, x fastest
//     volume     SHA-256 of the digests of its planes, z = 0 first
//
// A plane meets every brick of its layer. Whole rows of voxels wait in a buffer until none of them
// is missing; then each plane takes its part of them. Where one row of bricks takes more than the
// buffer, its bricks come once for each share of their planes or rows. As long as all bricks of a
// layer are uniform its planes are alike, and one of them is hashed.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
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

/// Whether a digest is the one stored for the same bytes; always in fuzz builds (crc32c.h).
inline bool digest_matches([[maybe_unused]] const Sha256Digest& found,
                           [[maybe_unused]] const Sha256Digest& stored) noexcept {
#if defined(OCTAVO_FUZZING)
  return true;
#else
  return found == stored;
#endif
}

/// Memory  `rows_bytes`; one row of voxels where that takes more: at most 8 MiB
class PlaneDigests {
 public:
  static constexpr std::int64_t kRowsBytes = std::int64_t{64} << 20;

  /// Both references outlive this.
  /// rows_bytes  the size of the buffer; no digest depends on it
  PlaneDigests(const VolumeDescription& description, const Levels& levels, MakeHasher make_hasher,
               std::int64_t rows_bytes = kRowsBytes);

  /// Starts with the first rows of a layer of tier 0.
  void begin_layer(std::int64_t layer);

  /// The bricks that come next, in no order; empty at the end of the layer.
  Box next_bricks() const;

  /// What a codec gives of one of these bricks, dense [z][y][x]. Several threads may put bricks at
  /// a time.
  void put(const Index3& brick, const void* decoded);
  /// The same for a brick of one code.
  void put_uniform(const Index3& brick, std::int64_t code);

  /// Hashes what the bricks gave, once all of them were put.
  void add_rows(const ForEach& for_each);

  /// Those of the layer, by z. Requires that no brick is left.
  std::vector<Sha256Digest> digests();

 private:
  /// Of the buffer: the codes of its uniform bricks, in the order of next_bricks().
  struct Share {
    Box room;  ///< the part of the layer that it holds
    std::vector<std::optional<std::int64_t>> codes;

    bool is_uniform() const;
  };

  void begin_share(const Index3& lo);
  Box bricks_of(const Box& room) const;
  std::uint8_t* row_at(std::int64_t x, std::int64_t y, std::int64_t z);
  Hasher& hasher_of(std::int64_t z);
  void fill_uniform(const Share& share, std::uint8_t* plane) const;
  void part_planes(const ForEach& for_each);

  const VolumeDescription& description_;
  const Levels& levels_;
  MakeHasher make_hasher_;
  std::size_t voxel_bytes_;
  Size3 share_;  ///< voxels of the buffer
  Box layer_;    ///< in voxels
  Share now_;    ///< that bricks are put into
  Bytes rows_;   ///< of its room, [z][y][x]
  /// The planes of the room are alike so far: these shares went to the first hasher alone.
  std::vector<Share> alike_;
  bool are_alike_ = true;
  std::vector<std::int64_t> hashed_as_;  ///< by plane of the layer: the one that has its digest
  std::vector<std::unique_ptr<Hasher>> hashers_;
};

}  // namespace octavo
