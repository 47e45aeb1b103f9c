// The fixed sections of a .8vo file: its 512-byte header and its 96-byte trailer.
//
//   offset 0                header        512 bytes; one write seals the file
//          512              slabs         the finest pieces, one slab a layer of bricks
//                           coarse levels pieces of level 1, 2, ... to the root
//          pages.offset     index pages
//          pages.end()      parts         what the directory lists
//          directory.offset directory     where parts stand; may be empty
//          metadata.offset  metadata      UTF-8 JSON, may end in spaces
//          root.offset      index root
//          file_bytes - 96  trailer
//
// The sections follow each other without a gap, so that every byte belongs to exactly one of them,
// and every one has a checksum. What is read here and means nothing to this program is of a newer
// version, not damaged: Error{unsupported_version}. Normative text: docs/format.md.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"

namespace octavo {

inline constexpr std::uint64_t kHeaderBytes = 512;
inline constexpr std::uint64_t kTrailerBytes = 96;
inline constexpr std::uint16_t kFormatMajor = 1;
inline constexpr std::uint16_t kFormatMinor = 0;
inline constexpr std::uint64_t kMaxMetadataBytes = std::uint64_t{16} << 20;
inline constexpr std::uint64_t kMaxModelBytes = std::uint64_t{16} << 20;
inline constexpr std::uint64_t kMaxPieceBytes = std::uint64_t{4} << 20;

/// A run of bytes of the file and their CRC-32C.
struct Section {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::uint32_t crc = 0;
  std::uint64_t end() const { return offset + length; }
};

/// What an extension of the header that this program does not know says of itself.
struct UnknownExtension {
  std::uint16_t tag = 0;
  std::uint64_t length = 0;  ///< in bytes
};

struct FileHeader {
  std::uint16_t major = kFormatMajor;
  std::uint16_t minor = kFormatMinor;
  bool is_sealed = false;
  VolumeDescription description;  ///< metadata are not part of the header
  std::vector<HalvingMask> halvings;
  double max_error = 0;           ///< in voxel units, whole for integer types; 0 is lossless
  /// Levels below it have no details and are interpolated: with a max error of 0, but lossy. 0: all
  /// have some.
  int detail_level = 0;
  /// Of a file that was read; none of them is written.
  std::vector<UnknownExtension> unknown_extensions;
  std::uint64_t build_id = 0;
  std::uint64_t file_bytes = 0;
  Section metadata;
  Section pages;
  Section root;
  Section directory;
  std::uint32_t crc = 0;  ///< of the block the header was parsed from
};

/// True when a volume can be without details below `detail_level`, which is above 0: grey integers,
/// and a level inside the bricks of tier 0.
bool can_leave_details_out(const VolumeDescription& volume, const Levels& levels, int detail_level);

using HeaderBlock = std::array<std::uint8_t, kHeaderBytes>;

/// The block of a header, its CRC included.
HeaderBlock encode_header(const FileHeader& header);

/// The CRC at the end of a block.
std::uint32_t load_header_crc(const HeaderBlock& block);

/// The length of a file when it was sealed.
std::uint64_t load_file_bytes(const HeaderBlock& block);

/// The header that stands in `bytes`, the first min(512, source_bytes) bytes of a source that has
/// `source_bytes` bytes. Everything it says of itself is proven: first that no number in it is one
/// of a later version, then ranges, the ladder of levels, that its sections tile the tail of the
/// file, and that index pages and root are as long as those of such a volume can be.
/// Throws Error{not_octavo, unsupported_version, truncated, corrupt, limit_exceeded}
FileHeader parse_header(ByteSpan bytes, std::uint64_t source_bytes);

/// The header of a file that is still being written, or whose build was interrupted: everything but
/// its length and sections, which are not known yet. Throws as parse_header does.
FileHeader parse_unsealed_header(const HeaderBlock& block);

/// A CRC of what the header says of the volume and of the metadata, then `content_hash`.
std::uint64_t make_build_id(const FileHeader& header, std::uint32_t content_hash);

struct FileTrailer {
  std::uint64_t build_id = 0;
  std::uint64_t file_bytes = 0;
  std::uint32_t header_crc = 0;  ///< the last four bytes of the header
  std::uint32_t crc = 0;         ///< of all bytes between header and trailer
  Sha256Digest voxel_digest{};   ///< SHA-256 of those of the planes of level 0
};

using TrailerBlock = std::array<std::uint8_t, kTrailerBytes>;

TrailerBlock encode_trailer(const FileTrailer& trailer);

/// The trailer in `bytes` (96 of them), proven to belong to `header`.
/// Throws Error{corrupt, unsupported_version}
FileTrailer parse_trailer(ByteSpan bytes, const FileHeader& header);

/// What a model's checksum takes in place of a level.
inline constexpr int kModelLevel = 0xff;

/// Checksum of a piece: over the build id, its global level and its o-code as well as its bytes, so
/// that one that was swapped, shifted or taken from another volume's file does not match.
/// level  global level of its finest segment, or kModelLevel
/// code   o-code of the brick in its tier, or the number of the model
std::uint32_t piece_crc(std::uint64_t build_id, int level, std::uint64_t code, ByteSpan bytes);

}  // namespace octavo
