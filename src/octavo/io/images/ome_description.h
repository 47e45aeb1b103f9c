// OME's XML in a TIFF's description, as far as planes need it.
#pragma once

#include <cstddef>
#include <string_view>

#include "octavo/io/images/tiff_description.h"

namespace octavo {

/// Adds the list of images that have pixels, and what one of them says, but for its TiffData.
/// image  its place in that list; nothing more is added where it has none there
void read_ome_description(std::string_view text, std::size_t image, TiffDescription& result);

/// Adds the TiffData of that image. Every file of a set has those of all files, so only one of them
/// is asked.
void read_ome_pages(std::string_view text, std::size_t image, TiffDescription& result);

}  // namespace octavo
