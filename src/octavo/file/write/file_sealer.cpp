#include "octavo/file/write/file_sealer.h"

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/file/write/index_builder.h"
#include "octavo/file/write/new_header.h"
#include "octavo/file/write/own_thumbnail.h"

namespace octavo {

namespace {

// Files above this get room for longer metadata.
constexpr std::uint64_t kPaddedFileBytes = std::uint64_t{1} << 20;

// Metadata as it stands in the file: in a copy of a large one a few more change nothing else.
Bytes metadata_bytes(const std::string& json, std::uint64_t file_bytes) {
  Bytes bytes(json.begin(), json.end());
  if (file_bytes <= kPaddedFileBytes) return bytes;
  const std::size_t needed = json.size() + kMetadataRoom;
  bytes.resize((needed + kMetadataBlock - 1) / kMetadataBlock * kMetadataBlock, ' ');
  return bytes;
}

}  // namespace

FileSealer::FileSealer(AppendFile& out, FileHeader& header, const Levels& levels,
                       const IndexRoot& root)
    : out_(out), header_(header), levels_(levels), root_(root) {}

// Returns the CRC-32C of the stream.
std::uint32_t FileSealer::append_stream(std::size_t stream, const CopyStream& copy,
                                        const std::vector<PlacedBytes>& placed) {
  std::uint32_t crc = 0;
  if (stream < placed.size()) {
    crc = placed[stream].crc;
    out_.pass_over(placed[stream].length, crc);
  }
  copy(stream, [&](ByteSpan bytes) {
    crc = crc32c(bytes, crc);
    out_.append(bytes);
  });
  return crc;
}

void FileSealer::append_streams(const CopyStream& copy, const std::vector<PlacedBytes>& placed) {
  const auto levels = static_cast<std::size_t>(levels_.count());
  for (std::size_t level = 1; level < levels; ++level) append_stream(level, copy, placed);
  header_.pages = {out_.size(), 0, 0};
  header_.pages.crc = append_stream(levels, copy, placed);
  header_.pages.length = out_.size() - header_.pages.offset;
}

// The parts, and the directory that lists them.
void FileSealer::append_parts(const std::vector<Part>& parts) {
  if (parts.size() > kMaxParts) misused("more than 1024 parts");
  std::vector<PartEntry> entries;
  for (const Part& part : parts) {
    PartEntry entry{part.tag, part.flags, {out_.size(), 0, 0}};
    bool is_ours = false;  // what fails
    try {
      part.copy_to([&](ByteSpan bytes) {
        is_ours = true;
        entry.bytes.crc = crc32c(bytes, entry.bytes.crc);
        out_.append(bytes);
        is_ours = false;
      });
    } catch (const Error& error) {
      if (!is_ours) failed_source_ = error.path();
      throw;
    }
    entry.bytes.length = out_.size() - entry.bytes.offset;
    entries.push_back(entry);
  }
  header_.directory = out_.append_section(encode_directory(entries));
}

void FileSealer::append_sections(std::vector<Part> parts, bool has_thumbnail) {
  if (has_thumbnail) {
    out_.flush();
    parts.insert(parts.begin(), own_thumbnail(out_.file(), header_, root_, levels_));
  }
  append_parts(parts);
  header_.metadata =
      out_.append_section(metadata_bytes(header_.description.metadata.text(), out_.size()));
  header_.root = out_.append_section(encode_root(root_, levels_, header_));
}

void FileSealer::seal(const Sha256Digest& voxel_digest) {
  header_.is_sealed = true;
  header_.file_bytes = out_.size() + kTrailerBytes;
  const HeaderBlock block = encode_header(header_);
  const std::uint32_t header_crc = load_header_crc(block);
  const TrailerBlock trailer = encode_trailer(
      {header_.build_id, header_.file_bytes, header_crc, out_.digest(), voxel_digest});
  out_.append(trailer);

  // Everything is on disk before the header says so.
  out_.flush();
  out_.file().sync();
  out_.write_header(block);
  out_.file().sync();

  // What stands there now must be what was meant.
  HeaderBlock header_read{};
  TrailerBlock trailer_read{};
  out_.file().read(0, header_read);
  out_.file().read(header_.file_bytes - kTrailerBytes, trailer_read);
  if (header_read != block || trailer_read != trailer) {
    throw Error(ErrorKind::io, "reads back other bytes than were written: a failing disk?");
  }
}

}  // namespace octavo
