// PNG files of fixed bytes: the same pixels give the same file in every program.
//
// No filter, one block with the fixed codes of deflate, and of all matches only those with the
// pixel and with the row before. Normative text: docs/format.md, section 7.
#pragma once

#include <cstddef>

#include "octavo/core/bytes.h"

namespace octavo {

struct PngPixels {
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t channels = 1;  ///< 1 grey, 3 red, green, blue
  Bytes values;              ///< [row][column][channel]
};

/// Requires as many values as the sizes say, and sides below 2^31.
/// Memory  three times the values
/// Source  ISO/IEC 15948 (PNG), RFC 1950 (zlib), RFC 1951 (deflate)
Bytes encode_fixed_png(const PngPixels& pixels);

}  // namespace octavo
