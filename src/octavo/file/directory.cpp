#include "octavo/file/directory.h"

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr std::uint32_t kKnownFlags = kRequiredPart | kVoxelPart | kRestPart;

bool is_tag_letter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

[[noreturn]] void fail_unknown(const PartEntry& entry, const std::string& what) {
  throw Error(ErrorKind::unsupported_version,
              name_of(entry.tag) + " " + what + ", which this program does not know", {},
              entry.bytes.offset);
}

void prove_known(const PartEntry& entry, std::uint32_t zero) {
  if ((entry.flags & ~kKnownFlags) != 0 || zero != 0) fail_unknown(entry, "has flags");
  if ((entry.flags & kRequiredPart) != 0 && !is_known(entry.tag)) fail_unknown(entry, "is needed");
}

// Requires whole entries.
std::vector<PartEntry> take_entries(ByteReader& in) {
  std::vector<PartEntry> entries;
  while (in.left() > 0) {
    PartEntry& entry = entries.emplace_back();
    const ByteSpan tag = in.take(entry.tag.size());
    std::transform(tag.begin(), tag.end(), entry.tag.begin(),
                   [](std::uint8_t byte) { return static_cast<char>(byte); });
    entry.flags = in.u32();
    entry.bytes.offset = in.u64();
    entry.bytes.length = in.u64();
    entry.bytes.crc = in.u32();
    prove_known(entry, in.u32());
  }
  return entries;
}

}  // namespace

bool is_known(const PartTag& tag) { return tag == kThumbnailTag; }

std::string name_of(const PartTag& tag) {
  std::string text(tag.begin(), tag.end());
  std::replace_if(text.begin(), text.end(), [](char c) { return !is_tag_letter(c); }, '?');
  return "part '" + text + "'";
}

Bytes encode_directory(std::span<const PartEntry> entries) {
  Bytes bytes;
  ByteWriter out(bytes);
  for (const PartEntry& entry : entries) {
    bytes.insert(bytes.end(), entry.tag.begin(), entry.tag.end());
    out.put_u32(entry.flags);
    out.put_u64(entry.bytes.offset);
    out.put_u64(entry.bytes.length);
    out.put_u32(entry.bytes.crc);
    out.put_u32(0);
  }
  return bytes;
}

std::vector<PartEntry> parse_directory(ByteSpan bytes, const FileHeader& header) {
  ByteReader in(bytes, "directory");
  if (bytes.size() % kPartEntryBytes != 0) in.fail("ends inside an entry");
  std::vector<PartEntry> entries = take_entries(in);
  std::uint64_t at = header.pages.end();
  bool has_thumbnail = false;
  for (const PartEntry& entry : entries) {
    if (!std::all_of(entry.tag.begin(), entry.tag.end(), is_tag_letter)) {
      in.fail("a tag that is no four letters");
    }
    if (entry.bytes.offset != at || entry.bytes.length > header.directory.offset - at) {
      in.fail("parts do not follow each other");
    }
    at = entry.bytes.end();
    if (entry.tag != kThumbnailTag) continue;
    if (has_thumbnail) in.fail("two thumbnails");
    if (entry.flags != kThumbnailFlags) in.fail("a thumbnail with other flags");
    if (entry.bytes.length > kMaxThumbnailBytes) in.fail("a thumbnail above 256 KiB");
    has_thumbnail = true;
  }
  if (at != header.directory.offset) in.fail("parts do not fill what is before it");
  return entries;
}

}  // namespace octavo
