// OME's XML in a TIFF's description, as far as planes need it.
#pragma once

#include <string_view>

#include "octavo/io/images/tiff_description.h"

namespace octavo {

/// Adds what the first Pixels element says, but for its TiffData; nothing where there is none.
void read_ome_description(std::string_view text, TiffDescription& result);

/// Adds the TiffData of the first Pixels element. Every file of a set has those of all files, so
/// only one of them is asked.
void read_ome_pages(std::string_view text, TiffDescription& result);

}  // namespace octavo
