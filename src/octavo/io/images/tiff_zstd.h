// Streams of ZSTD in strips and tiles of TIFF, proven by their length and by their checksum, where
// they have one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "octavo/io/images/tiff_stream.h"

namespace octavo {

/// Unpacks the frame of a block into its rows, as they are stored. Bytes behind the end of the
/// frame are passed over.
/// rows    get what it makes first; the rest is forgotten
/// most    after more bytes than that it is left; at least those of the rows
/// Throws  Error{io}, Error{out_of_memory}
/// Memory  about 300 kB, and as far as the frame looks back, at most 128 MiB
/// Source  RFC 8878
MadeBytes unpack_zstd_rows(const SourceFile& file, const CodedBlock& block,
                           std::span<std::byte> rows, std::uint64_t most);

}  // namespace octavo
