// Reads bricks whose level 0 has parts that decode alone: those parts that a box meets.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/bytes.h"
#include "octavo/core/error.h"
#include "octavo/core/recycled.h"
#include "octavo/core/unset_bytes.h"
#include "octavo/file/box_target.h"
#include "octavo/file/for_each.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/open_file.h"
#include "octavo/file/reader.h"

namespace octavo {

/// How the voxels that a request shares with a brick are read.
struct BrickReading {
  bool keeps = true;             ///< whole bricks in the cache, as those that a box cuts
  const ForEach* run = nullptr;  ///< parts in its tasks; null: one after the other
};

/// Thread-safe. Opened bricks, decoded down to level 1, are kept beside decoded parts.
class PartReader {
 public:
  /// Of the memory for decoded bricks, one part in so many is for opened ones.
  static constexpr std::uint64_t kOpenedShare = 8;

  /// file     outlives the reader, as does what options name
  /// decoded  bricks and parts that are kept; outlives the reader
  PartReader(const OpenFile& file, LruCache<UnsetBytes>& decoded, const ReaderOptions& options);

  /// So many bricks are opened at the same time.
  static constexpr std::size_t kBricksAtOnce = 4;

  /// Whether a brick that is not uniform has parts, and is not kept as a whole.
  bool reads(const BrickEntry& entry) const;

  /// Reads what `box` and bricks with parts share of level 0 of their tier, into the array of the
  /// box. Several take less time together; what is opened of them stands in memory at the same
  /// time.
  /// entries  at most kBricksAtOnce
  /// Throws Error{corrupt} naming brick, level and offset, of the first one; Error{cancelled}
  void read(std::span<const BrickEntry> entries, const Box& box, const BrickReading& how,
            const BoxTarget& out) const;

  /// Whether what `box` shares with the parts of a brick is kept.
  bool has_decoded(const BrickEntry& entry, const Box& box) const;

 private:
  struct Opened {
    std::shared_ptr<const BrickCodec> codec;  ///< of the parts
    std::unique_ptr<const BrickParts> parts;
  };
  /// What a request reads of a brick.
  struct Request {
    const BrickEntry& entry;
    const Opened& brick;
    int axis;  ///< along which planes are decoded one after the other
    Index3 at;  ///< where the brick begins
    const Box& box;
    const BoxTarget& out;
    bool keeps;
  };
  /// A part of which something is to be decoded.
  struct Missing {
    std::size_t number;
    bool is_new;  ///< nothing of it is kept
  };
  /// What holds bytes of parts.
  using PartBytes = Recycled<Bytes, PartReader>;
  /// The same with its bytes.
  struct Found {
    const Request* request;  ///< of its brick
    std::size_t number;
    bool is_new;
    ByteSpan bytes;
  };

  /// A part and where its voxels are.
  struct PartOf {
    const BrickEntry& entry;
    std::size_t number;
    Box box;
    int axis;  ///< as in Request
  };
  /// Decoded voxels of a part.
  struct Held {
    LruCache<UnsetBytes>::Pointer bytes;  ///< null where none are kept that do
    Box box;
    bool is_new = false;  ///< nothing of the part is kept
  };

  bool has_parts(const BrickEntry& entry) const;
  void keep(const Found& part, const Box& own,
            const std::shared_ptr<const UnsetBytes>& bytes) const;
  Held held(const PartOf& part, const Box& request, std::size_t voxel_bytes) const;
  std::vector<std::shared_ptr<const Opened>> opened(std::span<const BrickEntry> entries) const;
  std::vector<std::unique_ptr<BrickParts>> open_together(const BrickCodec& codec,
                                                         const BrickEntry& first,
                                                         std::span<const CodedBrick> bricks) const;
  std::shared_ptr<const Opened> kept(const BrickEntry& entry,
                                     std::shared_ptr<const BrickCodec> codec,
                                     std::unique_ptr<const BrickParts> parts,
                                     const BrickShape& shape) const;
  Error error_in(const BrickEntry& entry, int level, std::uint64_t offset,
                 const Error& error) const;
  void read_together(std::span<const BrickEntry> entries,
                     std::span<const std::shared_ptr<const Opened>> bricks, const Box& box,
                     const BrickReading& how, const BoxTarget& out) const;
  std::vector<Missing> copy_kept(const Request& request) const;
  void read_bytes(const Request& request, std::span<const Missing> missing,
                  std::vector<PartBytes>& reads, std::vector<Found>& found) const;
  void decode_found(std::span<const Found> parts) const;
  void decode(std::span<const Found> parts, std::span<const BrickParts::WantedOf> wanted) const;

  const OpenFile& file_;
  LruCache<UnsetBytes>& decoded_;
  mutable LruCache<Opened> opened_;
  const Progress* watcher_;
};

}  // namespace octavo
