// What tifffile, Zeiss and MetaMorph write of the pages of a TIFF, each in a way of its own.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "octavo/io/images/tiff_description.h"
#include "octavo/io/images/tiff_page.h"

namespace octavo {

/// Reads the description that tifffile writes, {"shape": [2, 5, 17, 19], "axes": "TZYX"} or
/// shape=(2, 5, 17, 19), into `result`. Without axes the last of several is that of slices, the one
/// before that of times. Other texts, and those of pages of another size, change nothing.
/// Throws  Error{source_rejected} where more axes have several planes than slices, channels and
///         times, or pages do not lie along Y and X; Error{limit_exceeded} beyond 63 bits of pages
void read_shaped_description(const std::string& text, const TiffPage& page,
                             const std::string& path, TiffDescription& result);

/// Reads the record of a Zeiss LSM file (CZ_LSMINFO, little-endian) into `result`: how many
/// slices, channels and times, and the size of voxels. A record that is cut or none changes
/// nothing.
void read_lsm_record(std::span<const std::byte> record, TiffDescription& result);

/// Notes that a MetaMorph stack has so many planes, of which its one page is the first.
void read_metamorph_planes(std::int64_t planes, TiffDescription& result);

}  // namespace octavo
