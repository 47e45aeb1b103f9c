// A picture drawn with fewer pixels, as large as it was to be.
#pragma once

#include <cstdint>

#include "octavo/render/picture.h"

namespace octavo {

/// Each pixel of `small` has `by` times its sides, the middles stay in place and colors run
/// straight between them.
/// Requires by >= 1 and pixels
Picture enlarged(const Picture& small, std::int64_t width, std::int64_t height, int by);

}  // namespace octavo
