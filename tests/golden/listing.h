// An .8vo file of one page written out byte by byte, as docs/format.md shows it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace octavo::testing {

/// One line per field: offset, up to 16 bytes in hex, what they are.
/// bytes  a sound file of one tier, one slab and one page without extensions
std::string annotated_listing(const std::vector<std::uint8_t>& bytes);

}  // namespace octavo::testing
