// Numbers and sizes as text, the same in every message, table and header.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"

namespace octavo {

/// The shortest text that reads back as the same number.
std::string exact_text(double value);

/// A number as people write it: up to six significant digits, no trailing zeros; "0.957", "-1024".
std::string number_text(double value);

/// Two numbers with as many digits as tell them apart, six at least: "1", "1.0000001".
std::pair<std::string, std::string> unlike_texts(double a, double b);

/// A number with up to seven digits, for positions and spacings that are compared.
std::string precise_text(double value);

/// "0.957 x 0.957 x 1.5".
std::string point_text(const Point3& point, const std::string& separator = " x ");

/// "512 x 512", "512 x 512 x 275".
std::string size_text(std::int64_t x, std::int64_t y);
std::string size_text(const Size3& size);

/// "12,700,800".
std::string count_text(std::int64_t count);

/// "1 voxel", "12,700,800 voxels".
/// plural  where it is not the noun with an s
std::string counted_text(std::int64_t count, const std::string& noun,
                         const std::string& plural = "");

/// "512 bytes", "61.0 MB" (powers of 1000).
std::string bytes_text(std::uint64_t bytes);

/// "0.42 s", "3 min 05 s", "2 h 10 min".
std::string duration_text(double seconds);

}  // namespace octavo
