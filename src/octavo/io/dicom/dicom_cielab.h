// Colors as DICOM recommends them: CIELab in three numbers of 16 bits.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "octavo/core/label_names.h"

namespace octavo {

/// The sRGB color of a Recommended Display CIELab Value, which colors that no screen shows are
/// brought to part by part; nothing for other than three numbers. L* of 0 to 100 and a* and b* of
/// -128 to 127 take all 16 bits each. White is D65, as those who write such values have it.
/// Source  DICOM PS3.3, C.10.7.1.1; IEC 61966-2-1 (sRGB); CIE 15 (L*a*b*)
std::optional<LabelColor> color_of_cielab(std::span<const std::uint16_t> encoded);

}  // namespace octavo
