// TIFF: one file with many pages, or a stack of files with one page each.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source/described_source.h"

namespace octavo {

/// files  one multi-page file, or single-page files in plane order
/// Spacing is taken from ImageJ's or OME's description where they have one. Every page is examined
/// before the first plane is delivered; no page is held.
/// Throws Error{source_rejected} naming the odd page with both sizes or types, channels, time
/// points,
///        color, or damaged data; Error{io}
std::unique_ptr<PlaneSource> open_tiff_source(const std::vector<std::string>& files,
                                              const SourceOptions& options);

}  // namespace octavo
