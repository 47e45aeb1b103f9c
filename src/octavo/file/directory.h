// The parts of a file that stand beside its voxels, and the directory that lists them.
//
//     entry = 4 letters or digits: tag | u32 flags | u64 offset | u64 length | u32 CRC | u32 zero
//
// Invariants
//   Parts follow each other without a gap, from the end of the index pages to the directory.
// Consequences
//   A program skips what it does not know, and can carry it into a file that it writes anew.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/file/layout.h"

namespace octavo {

inline constexpr std::uint64_t kMaxParts = 1024;
inline constexpr std::uint64_t kPartEntryBytes = 32;
inline constexpr std::uint64_t kMaxDirectoryBytes = kMaxParts * kPartEntryBytes;
inline constexpr std::uint64_t kMaxThumbnailBytes = std::uint64_t{256} << 10;

using PartTag = std::array<char, 4>;

/// A PNG of one plane, thumbnail.h. Depends on voxels and header.
inline constexpr PartTag kThumbnailTag = {'t', 'h', 'm', 'b'};

/// Whether this program knows what such parts hold.
bool is_known(const PartTag& tag);

/// "part 'thmb'"
std::string name_of(const PartTag& tag);

/// Who does not know such a part cannot read the file.
inline constexpr std::uint32_t kRequiredPart = 1;
/// Such a part follows from the voxels or from what the header says of them: who changes these and
/// does not know it leaves it out.
inline constexpr std::uint32_t kVoxelPart = 2;
/// Such a part follows from something else in the file: metadata, extensions, other parts, build id
/// or coded bytes. Who changes anything and does not know it leaves it out.
inline constexpr std::uint32_t kRestPart = 4;

/// A thumbnail has these flags and no others.
inline constexpr std::uint32_t kThumbnailFlags = kVoxelPart;

struct PartEntry {
  PartTag tag{};
  std::uint32_t flags = 0;
  Section bytes;
};

/// A part that waits to be written.
struct Part {
  PartTag tag{};
  std::uint32_t flags = 0;
  /// Gives its bytes to `sink`, a block at a time.
  std::function<void(const std::function<void(ByteSpan)>& sink)> copy_to;
};

Bytes encode_directory(std::span<const PartEntry> entries);

/// The parts in their order, proven to fill what is between pages and directory of `header`; first
/// of all that none of them is of a later version.
/// Throws Error{corrupt}; Error{unsupported_version} for a required part that this program does not
/// know, or an unknown flag
std::vector<PartEntry> parse_directory(ByteSpan bytes, const FileHeader& header);

}  // namespace octavo
