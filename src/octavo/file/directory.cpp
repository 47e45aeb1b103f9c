#include "octavo/file/directory.h"

#include <algorithm>

#include "octavo/core/error.h"
#include "octavo/file/byte_codec.h"

namespace octavo {

namespace {

constexpr std::uint32_t kKnownFlags = kRequiredPart | kDependentPart;

bool is_tag_letter(char c) {
  return (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
}

PartTag take_tag(ByteReader& in) {
  PartTag tag{};
  const ByteSpan bytes = in.take(tag.size());
  std::transform(bytes.begin(), bytes.end(), tag.begin(),
                 [](std::uint8_t byte) { return static_cast<char>(byte); });
  if (!std::all_of(tag.begin(), tag.end(), is_tag_letter)) in.fail("a tag that is no four letters");
  return tag;
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

}  // namespace

bool is_known(const PartTag& tag) { return tag == kThumbnailTag; }

std::string name_of(const PartTag& tag) {
  return "part '" + std::string(tag.begin(), tag.end()) + "'";
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
  std::vector<PartEntry> entries;
  std::uint64_t at = header.pages.end();
  while (in.left() > 0) {
    PartEntry entry;
    entry.tag = take_tag(in);
    entry.flags = in.u32();
    entry.bytes.offset = in.u64();
    entry.bytes.length = in.u64();
    entry.bytes.crc = in.u32();
    const std::uint32_t zero = in.u32();
    if (entry.bytes.offset != at || entry.bytes.length > header.directory.offset - at) {
      in.fail("parts do not follow each other");
    }
    at = entry.bytes.end();
    prove_known(entry, zero);
    if (entry.tag == kThumbnailTag) {
      const auto is_same = [](const PartEntry& e) { return e.tag == kThumbnailTag; };
      if (std::any_of(entries.begin(), entries.end(), is_same)) in.fail("two thumbnails");
      if (entry.bytes.length > kMaxThumbnailBytes) in.fail("a thumbnail above 256 KiB");
    }
    entries.push_back(entry);
  }
  if (at != header.directory.offset) in.fail("parts do not fill what is before it");
  return entries;
}

}  // namespace octavo
