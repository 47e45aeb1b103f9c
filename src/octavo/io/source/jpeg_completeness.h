// Whether a JPEG picture holds all of its values. Decoders fill up with grey what is missing at the
// end, and say nothing, or nothing that can be told from harmless faults.
#pragma once

#include <cstddef>
#include <span>

namespace octavo {

/// True where a picture holds all values that its frame header tells of: those of Huffman codes,
/// sequential (baseline, extended) or lossless, are stepped over one by one. The mark behind them
/// may lack where at most 3 bytes stand in its place: of more, which nothing needs, the first may
/// have been taken for values, as zeros in place of a lost end are. Of other processes, and where
/// tables lack, that mark alone is asked for.
/// tables   a datastream of the tables that the picture lacks, as JPEGTables of TIFF; empty without
/// picture  from its first mark on
/// Time     linear in the bytes, whatever they claim
/// Source   ITU-T T.81, annexes A, B, F.2.2 and H.2.2; ISO 12234-2 (JPEGTables)
bool is_whole_jpeg(std::span<const std::byte> tables, std::span<const std::byte> picture);

}  // namespace octavo
