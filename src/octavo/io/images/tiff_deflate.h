// Streams of Deflate in strips and tiles of TIFF, proven by their length and their checksum.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "octavo/io/images/tiff_predictor.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

/// Where the bytes of a strip or tile stand in a file.
struct DeflatedBlock {
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  bool is_mirrored = false;  ///< the bits of each byte stand in reverse (FillOrder 2)
};

/// What a stream makes.
struct InflatedLength {
  std::uint64_t bytes = 0;  ///< up to its end or its damage, or a few more than were allowed
  std::string damage;       ///< what is wrong with it; empty where it is whole or was left
};

/// Inflates a block and forgets what comes out of it. Bytes behind the end of the stream are
/// passed over.
/// most    after more bytes than that the stream is left
/// Throws  Error{io}, Error{out_of_memory}
/// Memory  about 100 kB
/// Source  RFC 1950
InflatedLength inflated_length(const SourceFile& file, const DeflatedBlock& block,
                               std::uint64_t most);

/// True where the checksum at the very end of a block is that of decoded rows, which are whole
/// then. False says nothing: other bytes may stand behind the stream.
/// prediction  that was undone: none or differences
/// rows        in native order
/// Throws      Error{io}
bool ends_with_checksum_of(const SourceFile& file, const DeflatedBlock& block,
                           TiffPrediction prediction, const PredictedRows& layout,
                           std::span<const std::byte> rows);

}  // namespace octavo
