#include "octavo/io/images/tiff_predictor.h"

#include <tiffio.h>

#include <cstring>
#include <vector>

#include "octavo/io/images/tiff_deflate.h"
#include "octavo/io/source/byte_order.h"

namespace octavo {

namespace {

/// Adds to each number the one `step` before it; sums wrap around, as differences did.
template <class T>
void add_up(std::span<std::byte> row, std::size_t step) {
  const std::size_t count = row.size() / sizeof(T);
  const auto at = [&](std::size_t i) { return row.data() + i * sizeof(T); };
  for (std::size_t i = step; i < count; ++i) {
    T before{};
    T value{};
    std::memcpy(&before, at(i - step), sizeof(T));
    std::memcpy(&value, at(i), sizeof(T));
    value = static_cast<T>(value + before);
    std::memcpy(at(i), &value, sizeof(T));
  }
}

void undo_differences(const PredictedRows& layout, std::span<std::byte> row) {
  switch (layout.value_bytes) {
    case 1: return add_up<std::uint8_t>(row, layout.step);
    case 2: return add_up<std::uint16_t>(row, layout.step);
    case 4: return add_up<std::uint32_t>(row, layout.step);
    default: return add_up<std::uint64_t>(row, layout.step);
  }
}

/// First bytes are the most significant ones, in files of either order.
void gather_bytes(const PredictedRows& layout, std::vector<std::byte>& apart,
                  std::span<std::byte> row) {
  if (layout.are_swapped) swap_values(row, layout.value_bytes);
  add_up<std::uint8_t>(row, layout.step);
  apart.assign(row.begin(), row.end());
  for (std::size_t i = 0; i < layout.row_values; ++i) {
    for (std::size_t byte = 0; byte < layout.value_bytes; ++byte) {
      row[i * layout.value_bytes + byte] = apart[byte * layout.row_values + i];
    }
  }
  if (needs_swap(true)) swap_values(row, layout.value_bytes);
}

}  // namespace

std::optional<TiffPrediction> prediction_left(std::uint16_t compression, std::uint64_t predictor,
                                              const StoredType& type) {
  const bool is_own = is_deflate(compression) || compression == COMPRESSION_ZSTD;
  const bool is_left =
      compression == COMPRESSION_PACKBITS || compression == COMPRESSION_LERC || is_own;
  if (!is_left || predictor == PREDICTOR_NONE) return TiffPrediction::none;
  const bool is_float = type == StoredType(VoxelType::float32) || type == WideType::float64;
  // libtiff takes floats for integers there.
  if (predictor == PREDICTOR_HORIZONTAL && (!is_float || is_own)) {
    return TiffPrediction::differences;
  }
  // LERC takes what it is given for numbers, of which it need not keep all bits.
  const bool are_bytes_kept = compression != COMPRESSION_LERC;
  if (is_float && predictor == PREDICTOR_FLOATINGPOINT && are_bytes_kept) {
    return TiffPrediction::float_bytes;
  }
  return std::nullopt;
}

void undo_prediction(TiffPrediction prediction, const PredictedRows& layout,
                     std::span<std::byte> rows) {
  if (prediction == TiffPrediction::none) return;
  const std::size_t row_bytes = layout.row_values * layout.value_bytes;
  std::vector<std::byte> apart;
  for (std::size_t at = 0; at + row_bytes <= rows.size(); at += row_bytes) {
    const std::span<std::byte> row = rows.subspan(at, row_bytes);
    if (prediction == TiffPrediction::differences) {
      undo_differences(layout, row);
    } else {
      gather_bytes(layout, apart, row);
    }
  }
}

}  // namespace octavo
