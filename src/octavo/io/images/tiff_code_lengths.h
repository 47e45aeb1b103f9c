// How many bytes codes of LZW and PackBits make, which have no checksum: flipped bits show where
// the number is not that of a strip or tile.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "octavo/io/images/tiff_stream.h"

namespace octavo {

/// What a block should make.
struct WantedRows {
  std::uint64_t bytes = 0;      ///< of the rows that it has at least
  std::uint64_t most = 0;       ///< bytes that it may make; after more its codes are left
  std::uint64_t row_bytes = 1;

  /// Whether rows end behind so many bytes, of which there are enough.
  bool may_end(std::uint64_t made) const { return made >= bytes && made % row_bytes == 0; }
};

/// Steps over the codes of a block. Up to three bytes behind whole rows are passed over, as are all
/// behind the code of the end.
/// coded   from its first code on, bits in the order of TIFF 6.0
/// Returns no number of bytes where the codes are of another kind: those of the first LZW of TIFF,
///         with bits in reverse, and those that do not begin with the code that clears the table
/// Source  TIFF 6.0, section 13
std::optional<MadeBytes> lzw_bytes(std::span<const std::byte> coded, const WantedRows& wanted);

/// The same for PackBits.
/// Source  TIFF 6.0, section 9
MadeBytes packbits_bytes(std::span<const std::byte> coded, const WantedRows& wanted);

}  // namespace octavo
