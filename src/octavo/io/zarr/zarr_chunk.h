// Chunks of zarr as they were before they were packed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/io/zarr/zarr_layout.h"

namespace octavo {

/// Undoes the packings of a chunk and the byte order of its values.
/// packed  as it stands in a file
/// Returns exactly layout.chunk_bytes(), the axes in the order of layout.codecs
/// Throws  Error{source_rejected}, without a path, for what is damaged or of another length
/// Memory  what a packing makes is never longer than the chunk and its checksums
std::vector<std::uint8_t> unpacked_chunk(std::vector<std::uint8_t> packed,
                                         const ZarrLayout& layout);

}  // namespace octavo
