#include "octavo/io/images/tiff_stream.h"

#include <tiffio.h>

#include <algorithm>

namespace octavo {

std::span<std::byte> BlockPieces::next() {
  const std::uint64_t wanted = std::min<std::uint64_t>(piece_.size(), left_.length);
  const std::size_t count = file_.read_some(
      left_.offset, std::span(piece_).first(static_cast<std::size_t>(wanted)));
  left_.offset += count;
  left_.length -= count;
  if (left_.is_mirrored) {
    TIFFReverseBits(reinterpret_cast<std::uint8_t*>(piece_.data()), static_cast<tmsize_t>(count));
  }
  return std::span(piece_).first(count);
}

}  // namespace octavo
