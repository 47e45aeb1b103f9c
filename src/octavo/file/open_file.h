// An opened .8vo file below the level of voxels: header, index, models, proven bytes.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/recycled.h"
#include "octavo/file/directory.h"
#include "octavo/file/index.h"
#include "octavo/file/layout.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/reader.h"
#include "octavo/file/slab_trailer.h"
#include "octavo/file/storage/read_twice.h"

namespace octavo {

/// Bytes of the file with a checksum of their own: a piece of a brick, or a model.
struct Piece {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint32_t crc = 0;
  int level = 0;           ///< as piece_crc takes it
  std::uint64_t code = 0;  ///< as piece_crc takes it
};

/// "brick o-code 0x1a3 level 5 at byte 81920", or "model 2 at byte 512".
std::string describe(const Piece& piece);

/// The segments of a brick and the bytes that they point into.
struct BrickBytes {
  Recycled<std::array<Bytes, kTierPieces>, BrickBytes> pieces;
  std::array<ByteSpan, kTierLevels> segments;
};

/// Immutable but for its caches; serves any number of threads.
class OpenFile {
 public:
  /// Two reads: the header, and the tail from the directory on; with the pages when the tail stays
  /// within options.max_tail_bytes. Throws what FileReader::open throws.
  OpenFile(std::shared_ptr<const ByteSource> source, const ReaderOptions& options);

  const ByteSource& source() const { return *source_; }
  const std::shared_ptr<const ByteSource>& shared_source() const { return source_; }
  const FileHeader& header() const { return header_; }
  const FileTrailer& trailer() const { return trailer_; }
  const VolumeDescription& description() const { return header_.description; }
  const Levels& levels() const { return levels_; }
  const IndexRoot& root() const { return root_; }
  /// In the order of the file.
  const std::vector<PartEntry>& parts() const { return parts_; }
  /// The one part with that tag, or null.
  const PartEntry* find_part(const PartTag& tag) const;

  /// The number of the page that describes a brick. Requires a position inside the grid.
  std::size_t page_of(int tier, const Index3& position) const;
  ByteRange page_range(int tier, std::size_t number) const;
  /// Whether a page is kept or its bytes are at hand.
  bool has_page(int tier, std::size_t number) const;

  /// A parsed page; the last ones used are kept. Throws Error{corrupt}.
  std::shared_ptr<const IndexPage> page(int tier, std::size_t number) const;

  /// Whether a codec is kept or its bytes are at hand.
  bool has_codec(std::uint32_t model) const;

  /// The codec of a model; the last ones used are kept. Throws Error{corrupt}.
  std::shared_ptr<const BrickCodec> codec(std::uint32_t model) const;

  /// The codec of a model in its bytes, proven to be one that such a file may have.
  /// Throws Error{corrupt, unsupported_version}
  std::shared_ptr<const BrickCodec> parse_model_in(std::uint32_t model, ByteSpan bytes) const;

  Piece model_piece(std::uint32_t model) const;
  Piece piece_of(const BrickEntry& entry, int piece) const;

  /// The bytes of a piece whose checksum matches.
  /// Throws Error{corrupt} naming it, both checksums and the flipped bit if a single one explains
  /// them.
  Bytes read_piece(const Piece& piece) const;
  /// The same into a buffer, which may have memory already.
  void read_piece(const Piece& piece, Bytes& bytes) const;

  /// Bytes from `offset` on inside a piece, whose checksum does not prove them. Requires that the
  /// piece holds them.
  void read_within(const Piece& piece, std::uint64_t offset, std::uint64_t length,
                   Bytes& bytes) const;

  /// The segments of a brick that one of its levels needs, the others empty; all for level 0.
  /// Throws Error{corrupt}
  BrickBytes read_segments(const BrickEntry& entry, int in_brick_level) const;

  /// The trailer of a slab in its bytes, proven to belong to it. Throws Error{corrupt}.
  SlabTrailer parse_trailer_of(std::int64_t slab, ByteSpan bytes) const;

  /// The trailer of a slab. Throws Error{corrupt} naming it.
  SlabTrailer slab_trailer(std::int64_t slab) const;

  /// The digests of all planes of level 0, from the slab trailers. Throws Error{corrupt}.
  std::vector<Sha256Digest> plane_digests() const;

  /// Gives the bytes of a part to `sink`, a block at a time. Throws Error{corrupt} at its end where
  /// its checksum does not match.
  void copy_part(const PartEntry& part, const std::function<void(ByteSpan)>& sink) const;

  /// The bytes of a section whose checksum matches.
  Bytes read_section(const Section& section, const char* what) const;

  /// The brick at `place` of page `number` of `tier`.
  BrickEntry entry_in_page(const IndexPage& page, int tier, std::size_t number,
                           std::int64_t place) const;

  BrickEntry entry_at(int tier, const Index3& position) const;

  /// What `read` returns, which may find bytes of `range` damaged: they are asked for once more
  /// (read_twice.h). No other member but read_within may be called in it.
  template <class Read>
  auto asked_again(const ByteRange& range, Read read) const {
    return asks_again_ ? read_twice(*source_, {&range, 1}, read) : read();
  }

 private:
  template <class F>
  auto named(F read) const;
  template <class F>
  auto named_again(const ByteRange& range, F read) const;
  void read_tail(const ReaderOptions& options);
  void fetch_pieces(const BrickEntry& entry, int first) const;
  Bytes read_bytes(std::uint64_t offset, std::uint64_t length) const;

  std::shared_ptr<const ByteSource> source_;
  bool asks_again_;
  FileHeader header_;
  FileTrailer trailer_;
  Levels levels_;
  IndexRoot root_;
  std::vector<PartEntry> parts_;
  Bytes pages_;  ///< the bytes of all pages when they came with the tail
  mutable LruCache<IndexPage> page_cache_;
  mutable LruCache<BrickCodec> codec_cache_;
  mutable std::mutex codec_mutex_;
};

}  // namespace octavo
