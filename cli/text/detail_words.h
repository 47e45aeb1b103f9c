// What is said of details that were left out.
#pragma once

#include <string>

#include "octavo/core/volume.h"

namespace octavo::cli {

/// "largest error 1204 HU, RMS 43.18 HU, PSNR 37.21 dB": what of it is known.
std::string detail_error_words(const VolumeDescription& volume, const DetailErrors& errors);

}  // namespace octavo::cli
