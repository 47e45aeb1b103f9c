// The size that a JPEG 2000 picture says of itself.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace octavo {

struct PictureSize {
  std::uint32_t columns = 0;
  std::uint32_t rows = 0;

  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

/// Samples of the first component of a codestream, bare or in a JP2 file; nothing where `bytes`,
/// the start of either, hold no size.
/// Source: ITU-T T.800, A.5.1 (Image and tile size) and B.2 (Component mapping)
std::optional<PictureSize> jpeg2000_size(std::span<const std::byte> bytes);

}  // namespace octavo
