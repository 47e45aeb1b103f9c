// Streams of Deflate in strips and tiles of TIFF, proven by their length and their checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "octavo/io/images/tiff_predictor.h"
#include "octavo/io/images/tiff_stream.h"

namespace octavo {

/// True for both numbers of a compression that stand for Deflate.
bool is_deflate(std::uint16_t compression);

/// Inflates a block into its rows, as they are stored. Bytes behind the end of the stream are
/// passed over.
/// rows    get what the stream makes first; the rest is forgotten
/// most    after more bytes than that the stream is left; at least those of the rows
/// Throws  Error{io}, Error{out_of_memory}
/// Memory  about 100 kB
/// Source  RFC 1950
MadeBytes inflate_rows(const SourceFile& file, const CodedBlock& block, std::span<std::byte> rows,
                       std::uint64_t most);

/// Whether ends_with_checksum_of can be true of such a block.
bool may_end_with_checksum(const CodedBlock& block, TiffPrediction prediction);

/// True where the checksum at the very end of a block is that of decoded rows, which are whole
/// then. False says nothing: other bytes may stand behind the stream.
/// prediction  that was undone
/// rows        in native order
/// Throws      Error{io}
bool ends_with_checksum_of(const SourceFile& file, const CodedBlock& block,
                           TiffPrediction prediction, const PredictedRows& layout,
                           std::span<const std::byte> rows);

}  // namespace octavo
