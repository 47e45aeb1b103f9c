// What programs did to the values of a row before they compressed it, where libtiff leaves it so.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "octavo/io/source/stored_type.h"

namespace octavo {

/// What stands in rows in place of their values.
enum class TiffPrediction {
  none,         ///< the values
  differences,  ///< integers: each but the first ones is the step from the pixel before it
  float_bytes,  ///< floats: first bytes of all values, then all second ones; of these the steps
};

/// What libtiff leaves in the rows of a page: it undoes a predictor for LZW and LZMA, while others
/// write one with PackBits and LERC as well. For ZSTD, which is decoded without libtiff, and for
/// Deflate, which may be, what stands in the stream. That of an uncompressed page or of a picture
/// codec (JPEG, WebP) is a tag that nobody heeds.
/// predictor  the tag; 1: none
/// Returns    nothing for a predictor that such values cannot have
/// Source     TIFF 6.0, section 14; Adobe Photoshop TIFF Technical Note 3
std::optional<TiffPrediction> prediction_left(std::uint16_t compression, std::uint64_t predictor,
                                              const StoredType& type);

/// How the values of a block stand in its rows.
struct PredictedRows {
  std::size_t row_values = 1;   ///< of all samples; with what fills a tile
  std::size_t step = 1;         ///< values from a sample to the same of the next pixel
  std::size_t value_bytes = 1;  ///< 1, 2, 4 or 8
  bool are_swapped = false;     ///< libtiff reversed the bytes of each value after decoding
};

/// Gives decoded rows their values, in native order. Requires whole rows.
void undo_prediction(TiffPrediction prediction, const PredictedRows& layout,
                     std::span<std::byte> rows);

}  // namespace octavo
