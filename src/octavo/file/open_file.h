// An opened .8vo file below the level of voxels: header, index, models, proven bytes.
#pragma once

#include <memory>
#include <mutex>

#include "octavo/codec/brick_codec.h"
#include "octavo/file/index.h"
#include "octavo/file/layout.h"
#include "octavo/file/lru_cache.h"
#include "octavo/file/reader.h"

namespace octavo {

/// A piece of the file with its own checksum: a segment or a model.
struct Piece {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint32_t crc = 0;
  int level = 0;           ///< as segment_crc takes it
  std::uint64_t code = 0;  ///< as segment_crc takes it
};

/// "brick o-code 0x1a3 level 5 at byte 81920", or "model 2 at byte 512".
std::string describe(const Piece& piece);

/// The index pages are read with the tail when both together are not larger than this.
inline constexpr std::uint64_t kTailBytes = std::uint64_t{1} << 20;

/// Immutable but for its caches; serves any number of threads.
class OpenFile {
 public:
  /// Two reads: the header, and the tail from the metadata on; with the pages when the tail stays
  /// within 1 MiB. Throws what FileReader::open throws.
  OpenFile(std::shared_ptr<const ByteSource> source, const ReaderOptions& options);

  const ByteSource& source() const { return *source_; }
  const FileHeader& header() const { return header_; }
  const FileTrailer& trailer() const { return trailer_; }
  const VolumeDescription& description() const { return header_.description; }
  const Levels& levels() const { return levels_; }
  const IndexRoot& root() const { return root_; }

  /// A parsed page; the last ones used are kept. Throws Error{corrupt}.
  std::shared_ptr<const IndexPage> page(int tier, std::size_t number) const;

  /// The codec of a model; the last ones used are kept. Throws Error{corrupt}.
  std::shared_ptr<const BrickCodec> codec(std::uint32_t model) const;

  Piece model_piece(std::uint32_t model) const;

  /// The bytes of a piece whose checksum matches.
  /// Throws Error{corrupt} naming it, both checksums and the flipped bit if a single one explains
  /// them.
  Bytes read_piece(const Piece& piece) const;

  /// Bytes from `offset` on inside a piece, whose checksum does not prove them. Requires that the
  /// piece holds them.
  Bytes read_within(const Piece& piece, std::uint64_t offset, std::uint64_t length) const;

  /// The bytes of a section whose checksum matches.
  Bytes read_section(const Section& section, const char* what) const;

  /// The brick at `place` of page `number` of `tier`.
  BrickEntry entry_in_page(const IndexPage& page, int tier, std::size_t number,
                           std::int64_t place) const;

  BrickEntry entry_at(int tier, const Index3& position) const;

 private:
  void read_tail(std::uint64_t max_metadata_bytes);
  Bytes read_bytes(std::uint64_t offset, std::uint64_t length) const;

  std::shared_ptr<const ByteSource> source_;
  FileHeader header_;
  FileTrailer trailer_;
  Levels levels_;
  IndexRoot root_;
  Bytes pages_;  ///< the bytes of all pages when they came with the tail
  mutable LruCache<IndexPage> page_cache_;
  mutable LruCache<BrickCodec> codec_cache_;
  mutable std::mutex codec_mutex_;
};

}  // namespace octavo
