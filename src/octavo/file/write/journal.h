// The journal of a build: what must be known, besides the growing file, to go on after the program
// ended.
//
// It stands beside the growing file while that grows, and goes when the build is done; no .8vo file
// holds any of it. It takes the place of the scratch file: the segments and pages that wait for
// their turn stand in it, block by block.
//
//   record = u32 type | u32 stream | u64 length | u32 CRC of the record's offset (u64), of the
//            fields before and of the payload | payload
//   head   = type 1: magic "8jrn" | u32 version | varint length, settings | 512 bytes of header,
//            unsealed | metadata
//   block  = type 2: bytes of a stream of the spool
//   group  = type 3: everything else that is known of the layers since the group before
//
// Invariants
//   The head is first; the blocks of a group stand before it.
//   A record that was cut off, changed or moved does not match its CRC.
// Consequences
//   A journal is read from its start up to the first record that is not whole; behind the last
//   group before that, it can be cut off and continued.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/index.h"
#include "octavo/file/layout.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

/// Stands in JournalHead::settings for an option that was left out.
inline constexpr const char* kSettingNotGiven = "not given";

/// The line in JournalHead::settings of a file that is to have a thumbnail.
inline constexpr const char* kThumbnailSetting = "thumbnail: given\n";

/// What a build is of and how it is done: equal heads continue each other.
struct JournalHead {
  std::string settings;       ///< lines "NAME: VALUE"
  HeaderBlock header{};       ///< as it stands in the growing file
  std::string metadata;
};

/// A run of whole brick layers of tier 0.
struct JournalGroup {
  std::int64_t end_layer = 0;     ///< the first layer behind it
  std::uint32_t voxels_crc = 0;   ///< CRC-32C of its voxels, as the source gave them
  std::uint64_t file_bytes = 0;   ///< of the growing file at its end
  std::uint32_t digest = 0;       ///< CRC-32C of the growing file behind its header, up to there
  double squared_error = 0;       ///< of all bricks up to there (EncodedBrick::squared_error)
  std::vector<ModelRef> models;
  std::vector<std::uint32_t> slab_trailer_bytes;
  std::vector<PageRef> pages;     ///< of tier 0; totals in segment_start
  std::vector<std::int64_t> parents;  ///< of its bricks, in brick order
  std::vector<Sha256Digest> plane_digests;  ///< of its planes, by z
};

/// Bytes of a spooled stream in the journal.
struct JournalBlock {
  std::size_t stream = 0;
  std::uint64_t offset = 0;
  std::uint32_t length = 0;
};

/// A group as journals and parts of a file hold it.
Bytes encode_group(const JournalGroup& group);

/// Throws Error{corrupt} where the bytes are no group; what it says is not proven.
JournalGroup parse_group(ByteSpan bytes);

/// Appends records. Every call throws Error{io}.
class Journal {
 public:
  /// Begins a journal in an empty file.
  Journal(std::unique_ptr<StorageFile> file, const JournalHead& head);
  /// Continues one behind byte `end`, where a record ended; what stands there is cut off.
  Journal(std::unique_ptr<StorageFile> file, std::uint64_t end);

  /// Returns the offset of `bytes` in the journal.
  std::uint64_t append_block(std::size_t stream, ByteSpan bytes);
  void append_group(const JournalGroup& group);

  std::uint64_t size() const { return bytes_; }
  StorageFile& file() { return *file_; }

 private:
  std::uint64_t append(std::uint32_t type, std::size_t stream, ByteSpan payload);

  std::unique_ptr<StorageFile> file_;
  std::uint64_t bytes_ = 0;
};

/// A group with its blocks.
struct WholeGroup {
  JournalGroup group;
  std::vector<JournalBlock> blocks;
  std::uint64_t journal_end = 0;  ///< where its record ends
};

/// The head of a journal; nothing when it is not whole. Throws Error{io}.
std::optional<JournalHead> read_journal_head(const StorageFile& file);

/// The groups of a journal up to the first record that is not whole. Throws Error{io}.
/// Memory  about 100 bytes per 1024 bricks and 8 bytes per brick
std::vector<WholeGroup> read_journal_groups(const StorageFile& file);

}  // namespace octavo
