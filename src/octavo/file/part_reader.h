// Reads bricks whose level 0 has parts that decode alone: those parts that a box meets.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/bytes.h"
#include "octavo/file/box_target.h"
#include "octavo/file/for_each.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/open_file.h"
#include "octavo/file/reader.h"

namespace octavo {

/// How the voxels that a request shares with a brick are read.
struct BrickReading {
  bool keeps = true;             ///< in the cache what was decoded
  const ForEach* run = nullptr;  ///< parts in its tasks; null: one after the other
};

/// Thread-safe. Opened bricks, decoded down to level 1, are kept beside decoded parts.
class PartReader {
 public:
  /// Of the memory for decoded bricks, one part in so many is for opened ones.
  static constexpr std::uint64_t kOpenedShare = 8;

  /// file     outlives the reader, as does what options name
  /// decoded  bricks and parts that are kept; outlives the reader
  PartReader(const OpenFile& file, LruCache<Bytes>& decoded, const ReaderOptions& options);

  /// Reads what `box` and the brick share of level 0 of its tier, into the array of the box. False
  /// where the brick has no parts, or where it is kept as a whole.
  /// Throws Error{corrupt} naming brick, level and offset; Error{cancelled}
  bool read(const BrickEntry& entry, const Box& box, const BrickReading& how,
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
    const Index3& at;  ///< where the brick begins
    const Box& box;
    const BoxTarget& out;
    bool keeps;
  };
  /// A part of which something is to be decoded.
  struct Missing {
    std::size_t number;
    bool is_new;  ///< nothing of it is kept
  };
  /// The same with its bytes.
  struct Found {
    std::size_t number;
    bool is_new;
    ByteSpan bytes;
  };

  std::shared_ptr<const Opened> opened(const BrickEntry& entry) const;
  std::vector<Found> read_bytes(const Request& request, std::span<const Missing> missing,
                                std::vector<Bytes>& reads) const;
  void decode_found(const Request& request, std::span<const Found> parts) const;
  void decode(const Request& request, std::span<const BrickParts::Wanted> wanted) const;

  const OpenFile& file_;
  LruCache<Bytes>& decoded_;
  mutable LruCache<Opened> opened_;
  const Progress* watcher_;
};

}  // namespace octavo
