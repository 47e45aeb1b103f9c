#include "octavo/io/images/tiff_loss.h"

#include <tiffio.h>

#include <string_view>

#include "octavo/io/source/header_bytes.h"

namespace octavo {

namespace {

/// LERC keeps values within an error that stands in front of each block. Below 1 it changes no
/// whole numbers.
bool is_lossy_lerc(const StoredType& type, std::span<const std::byte> start,
                   std::string_view text) {
  constexpr std::string_view kMagic = "Lerc2 ";
  if (start.size() < kBlockStartBytes || !text.starts_with(kMagic)) return true;
  const HeaderBytes read(start, false);
  const auto version = read.at<std::int32_t>(kMagic.size());
  if (version < 2 || version > 5) return true;
  // Seven numbers of 32 bits; from version 3 on a checksum, from 4 on the values of a voxel.
  const std::size_t numbers = version == 2 ? 7 : version == 3 ? 8 : 9;
  const auto error = read.at<double>(kMagic.size() + numbers * sizeof(std::int32_t));
  const bool is_float = type.voxel() == VoxelType::float32;
  return is_float ? error != 0 : !(error < 1);
}

}  // namespace

bool has_varying_loss(std::uint16_t compression) {
  return compression == COMPRESSION_LERC || compression == COMPRESSION_WEBP;
}

bool is_lossy_block(std::uint16_t compression, const StoredType& type,
                    std::span<const std::byte> start) {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), start.size());
  if (compression == COMPRESSION_LERC) return is_lossy_lerc(type, start, text);
  if (compression == COMPRESSION_WEBP) {
    constexpr std::size_t kChunkStart = 12;  // behind "RIFF", a length and "WEBP"
    return text.size() < kChunkStart || !text.substr(kChunkStart).starts_with("VP8L");
  }
  return compression == COMPRESSION_JPEG || compression == COMPRESSION_OJPEG;
}

}  // namespace octavo
