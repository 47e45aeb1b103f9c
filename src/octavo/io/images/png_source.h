// PNG: one grey picture per plane.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// files  in plane order; grey of up to 8 bits becomes uint8, of 16 bits uint16. Values are those
///        stored, but where pictures of 1, 2, 4 and 8 bits are mixed all are scaled to 8 bits.
/// Throws Error{source_rejected} on color, transparency, mixed sizes or damaged files; Error{io}
std::unique_ptr<PlaneSource> open_png_source(const std::vector<std::string>& files,
                                             const SourceOptions& options);

}  // namespace octavo
