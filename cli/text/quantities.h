// Numbers as people write and read them: bytes, durations, positions, boxes, colors.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/geometry.h"
#include "octavo/core/text.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/volume_parts.h"

namespace octavo::cli {

/// "500M", "2G", "1.5GiB", "4096": K, M, G, T are powers of 1024. Throws Error{invalid_argument}.
std::uint64_t parse_bytes(const std::string& text);

/// "1e13", "1000000". Throws Error{invalid_argument}.
std::uint64_t parse_voxel_count(const std::string& text);

/// One finite number that fills `text`. Throws Error{invalid_argument} naming `what`.
double parse_number(const std::string& text, const std::string& what);

/// One integer that fills `text`. Throws Error{invalid_argument} naming `what`.
std::int64_t parse_integer(const std::string& text, const std::string& what);

/// "12,700,800".
inline std::string count_of(std::uint64_t count) {
  return count_text(static_cast<std::int64_t>(count));
}

/// "1 triangle", "12,700,800 triangles".
inline std::string count_of(std::uint64_t count, const std::string& noun) {
  return counted_text(static_cast<std::int64_t>(count), noun);
}

/// The pieces of `text` between separators; empty pieces are kept.
std::vector<std::string> split(const std::string& text, char separator);

/// Numbers with commas in between. Throws Error{invalid_argument} naming `what` unless there are
/// `count` of them.
/// form  what is expected, "CENTER,WIDTH"
std::vector<double> parse_numbers(const std::string& text, const std::string& what,
                                  std::size_t count, const char* form);

/// A largest difference: one finite number of 0 or more. Throws Error{invalid_argument}.
double parse_max_error(const std::string& text);

/// "x,y,z". Throws Error{invalid_argument} naming `what`.
Point3 parse_point(const std::string& text, const std::string& what);
Index3 parse_index(const std::string& text, const std::string& what);
/// "x,y,z", or one number for all three.
Point3 parse_spacing(const std::string& text, const std::string& what);

/// "0:64,0:64,16:32": a half-open box as options take it.
std::string box_text(const Box& box);

/// A name, or "#rrggbb". Throws Error{invalid_argument} naming `what`.
Color parse_color(const std::string& text, const std::string& what);

/// A half-open box of samples, "x0:x1,y0:y1,z0:z1"; a side left empty is the end of the volume.
/// Throws Error{invalid_argument} naming `what`.
AskedBox parse_box(const std::string& text, const std::string& what = "--box");

/// A box in millimeters (LPS world space).
BoxMm parse_box_mm(const std::string& text, const std::string& what = "--box-mm");

}  // namespace octavo::cli
