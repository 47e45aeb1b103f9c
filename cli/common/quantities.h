// Numbers as people write and read them: bytes, durations, positions, boxes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/levels.h"

namespace octavo::cli {

/// "500M", "2G", "1.5GiB", "4096": K, M, G, T are powers of 1024. Throws Error{invalid_argument}.
std::uint64_t parse_bytes(const std::string& text);

/// One finite number that fills `text`. Throws Error{invalid_argument} naming `what`.
double parse_number(const std::string& text, const std::string& what);

/// One integer that fills `text`. Throws Error{invalid_argument} naming `what`.
std::int64_t parse_integer(const std::string& text, const std::string& what);

/// The pieces of `text` between separators; empty pieces are kept.
std::vector<std::string> split(const std::string& text, char separator);

/// "x,y,z". Throws Error{invalid_argument} naming `what`.
Point3 parse_point(const std::string& text, const std::string& what);
Index3 parse_index(const std::string& text, const std::string& what);
/// "x,y,z", or one number for all three.
Point3 parse_spacing(const std::string& text, const std::string& what);

/// A half-open box of samples, "x0:x1,y0:y1,z0:z1"; a side left empty is the end of the volume.
/// Throws Error{invalid_argument} when the box is empty or not inside `size`, naming the axis.
Box parse_box(const std::string& text, const Size3& size);

/// The samples whose centers lie in a box in millimeters (LPS world space), clipped to the volume.
/// Throws Error{invalid_argument} when there are none.
Box parse_box_mm(const std::string& text, const Geometry& geometry, const Size3& size);

/// Throws Error{invalid_argument} unless 0 <= level < levels.count().
void check_level(const Levels& levels, int level);

/// "512 bytes", "61.0 MB" (powers of 1000).
std::string bytes_text(std::uint64_t bytes);
/// "0.42 s", "3 min 05 s", "2 h 10 min".
std::string duration_text(double seconds);
/// Up to six significant digits, no trailing zeros: "0.957", "1.5", "-1024".
std::string number_text(double value);
/// "512 x 512 x 275".
std::string size_text(const Size3& size);
/// "0.957 x 0.957 x 1.5".
std::string point_text(const Point3& point, const std::string& separator = " x ");
/// "12,700,800".
std::string count_text(std::int64_t count);
/// "1 voxel", "12,700,800 voxels".
/// plural  where it is not the noun with an s
std::string counted_text(std::int64_t count, const std::string& noun,
                         const std::string& plural = "");

}  // namespace octavo::cli
