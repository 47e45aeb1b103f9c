// Whether the compression of a TIFF page changed its voxels.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "octavo/io/source/stored_type.h"

namespace octavo {

/// Bytes of a block that may be asked for.
constexpr std::size_t kBlockStartBytes = 64;

/// True for kinds of compression that may be lossy or not, so that the block itself is asked.
bool has_varying_loss(std::uint16_t compression);

/// True where values may be others than they were: always in JPEG; in LERC and WebP as the block
/// says, and where it does not say.
/// compression  the number of the tag
/// start        of the first strip or tile of the page; asked where has_varying_loss
/// Source       "Lerc2" of the LERC library, versions 2 to 5; RFC 9649 (WebP)
bool is_lossy_block(std::uint16_t compression, const StoredType& type,
                    std::span<const std::byte> start);

}  // namespace octavo
