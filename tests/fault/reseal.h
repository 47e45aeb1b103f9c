// Gives a changed file fitting checksums again, so that tests get past them.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/file/layout.h"

namespace octavo::testing {

/// Where the sections of a sound file stand.
inline FileHeader header_of(const std::vector<std::uint8_t>& bytes) {
  return parse_header(ByteSpan(bytes).first(kHeaderBytes), bytes.size());
}

/// Recomputes the checksums of root and metadata, of the header and of the trailer.
/// layout  of the sound file the bytes were made from
inline void reseal(std::vector<std::uint8_t>& bytes, const FileHeader& layout) {
  const auto crc_of = [&](const Section& section) {
    return crc32c(ByteSpan(bytes).subspan(section.offset, section.length));
  };
  store_little_endian(crc_of(layout.metadata), bytes.data() + 232 + 16);
  store_little_endian(crc_of(layout.root), bytes.data() + 280 + 16);
  const std::uint32_t header_crc = crc32c(ByteSpan(bytes).first(508));
  store_little_endian(header_crc, bytes.data() + 508);
  std::uint8_t* trailer = bytes.data() + bytes.size() - kTrailerBytes;
  std::copy_n(bytes.data() + 216, 16, trailer + 8);
  store_little_endian(header_crc, trailer + 24);
  const ByteSpan between =
      ByteSpan(bytes).subspan(kHeaderBytes, bytes.size() - kHeaderBytes - kTrailerBytes);
  store_little_endian(crc32c(between), trailer + 28);
  store_little_endian(crc32c({trailer, 92}), trailer + 92);
}

}  // namespace octavo::testing
