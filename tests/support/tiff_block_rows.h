// What decoders of strips and tiles of TIFF make of a block in the midst of a file.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "octavo/io/images/tiff_stream.h"
#include "support/source_files.h"

namespace octavo::testing {

struct BlockRows {
  MadeBytes made;
  std::string rows;
};

/// A decoder that tests call with the bytes of a block.
struct BlockDecoder {
  MadeBytes (*decode)(const SourceFile&, const CodedBlock&, std::span<std::byte>, std::uint64_t);

  /// A block with other bytes around it, as `row_bytes` of rows.
  BlockRows operator()(const TempFolder& folder, const std::string& block, std::size_t row_bytes,
                       std::uint64_t most, bool is_mirrored = false) const {
    write_file(folder.file("block"), "head" + block + "tail");
    BlockRows result;
    result.rows.resize(row_bytes, '?');
    result.made = decode(SourceFile(folder.file("block")), {4, block.size(), is_mirrored},
                         std::as_writable_bytes(std::span(result.rows)), most);
    return result;
  }
};

}  // namespace octavo::testing
