// OME's XML in a TIFF's description, as far as planes need it.
#pragma once

#include <string_view>

#include "octavo/io/tiff_description.h"

namespace octavo {

/// Adds what the first Pixels element says; nothing where there is none.
void read_ome_description(std::string_view text, TiffDescription& result);

}  // namespace octavo
