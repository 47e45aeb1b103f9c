// Numbers and sizes as text, the same in every message, table and header.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/box.h"

namespace octavo {

/// The shortest text that reads back as the same number.
std::string exact_text(double value);

/// A number as people write it: up to 7 significant digits.
std::string number_text(double value);

/// "512 x 512", "512 x 512 x 275".
std::string size_text(std::int64_t x, std::int64_t y);
std::string size_text(const Size3& size);

}  // namespace octavo
