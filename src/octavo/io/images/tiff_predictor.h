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
  differences,  ///< of values as integers: each but the first is the step from the pixel before it
  float_bytes,  ///< of floats: all first bytes, then all second ones, and of these the differences
};

/// What is left to undo in decoded rows.
///
///     LZW, LZMA                  nothing: libtiff undoes their predictor
///     PackBits, LERC             the predictor: some programs write one, and libtiff leaves it
///     Deflate, ZSTD              the predictor: their streams are decoded here
///     none, JPEG, WebP, others   nothing: the tag means nothing
///
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
  bool are_swapped = false;     ///< the bytes of each value were reversed after decoding
};

/// Gives decoded rows their values, in native order. Requires whole rows.
void undo_prediction(TiffPrediction prediction, const PredictedRows& layout,
                     std::span<std::byte> rows);

}  // namespace octavo
