// What a compressed picture says of itself: its size and the bits of its numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace octavo {

struct PictureHead {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;
  std::int64_t bits = 0;   ///< of a sample
  bool is_signed = false;  ///< only JPEG 2000 knows signs
  std::int64_t samples = 1;

  friend bool operator==(const PictureHead&, const PictureHead&) = default;
};

/// The head of a JPEG, JPEG-LS or JPEG 2000 picture (bare or in a JP2 file), the columns and rows
/// those of its first component; nothing where `bytes`, the start of it, hold none.
/// Source: ITU-T T.81, B.2.2 (Frame header); ITU-T T.87, C.2.2;
///         ITU-T T.800, A.5.1 (Image and tile size) and B.2 (Component mapping)
std::optional<PictureHead> picture_head(std::span<const std::byte> bytes);

/// Where the number of bits of a sample stands in a lossless JPEG picture of Huffman codes; nothing
/// in any other.
/// Source: ITU-T T.81, B.2.2 (Frame header)
std::optional<std::size_t> lossless_bits_place(std::span<const std::byte> picture);

}  // namespace octavo
