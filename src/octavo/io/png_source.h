// PNG: one grey picture per plane.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/described_source.h"

namespace octavo {

/// files  in plane order; grey of 1 to 8 bits becomes uint8 as stored, of 16 bits uint16
/// Throws Error{source_rejected} on colour, transparency, mixed sizes or damaged files; Error{io}
std::unique_ptr<PlaneSource> open_png_source(const std::vector<std::string>& files,
                                             const SourceOptions& options);

}  // namespace octavo
