// The functions that JavaScript calls. Volumes are pointers, which live as long as their instance;
// lists come back in one place each, good until the next call. What fails does not come back:
// host.cpp.
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/label_color.h"
#include "octavo/file/layout.h"
#include "octavo/octree/o_code.h"
#include "web_volume.h"

using octavo::Box;
using octavo::web::Numbers;
using octavo::web::WebVolume;

namespace {

Numbers numbers;
std::string text;

const double* keep(Numbers list) {
  numbers = std::move(list);
  return numbers.data();
}

const char* keep(std::string words) {
  text = std::move(words);
  return text.c_str();
}

/// x, y, z of the lower corner, then of the upper one.
Box box_of(const double* corners) {
  const auto at = [&](int i) { return static_cast<std::int64_t>(corners[i]); };
  return {{at(0), at(1), at(2)}, {at(3), at(4), at(5)}};
}

}  // namespace

// Exported to JavaScript under its own name.
#define OCTAVO_EXPORT(name) extern "C" __attribute__((export_name(#name)))

OCTAVO_EXPORT(octavo_allocate)
void* octavo_allocate(std::size_t bytes) {
  void* const memory = std::malloc(bytes);
  if (memory != nullptr || bytes == 0) return memory;
  throw octavo::Error(octavo::ErrorKind::out_of_memory,
                      "no memory left for " + std::to_string(bytes) + " bytes");
}

OCTAVO_EXPORT(octavo_free)
void octavo_free(void* memory) { std::free(memory); }

/// The length of the file that begins with these bytes: of all kinds of files that are none, too.
OCTAVO_EXPORT(octavo_length_of)
double octavo_length_of(const std::uint8_t* bytes, std::size_t count) {
  octavo::HeaderBlock block{};
  if (count < block.size()) return static_cast<double>(count);
  std::copy_n(bytes, block.size(), block.begin());
  constexpr std::uint64_t kMostBytes = std::uint64_t{1} << 53;
  return static_cast<double>(std::min(octavo::load_file_bytes(block), kMostBytes));
}

OCTAVO_EXPORT(octavo_create)
WebVolume* octavo_create(double size, const char* name, std::size_t name_bytes) {
  return new WebVolume(static_cast<std::uint64_t>(size), {name, name_bytes});
}

OCTAVO_EXPORT(octavo_put)
void octavo_put(WebVolume* volume, double offset, const std::uint8_t* bytes, std::size_t count) {
  volume->source().put(static_cast<std::uint64_t>(offset), {bytes, count});
}

/// Drops what was put in first, but for so many bytes.
OCTAVO_EXPORT(octavo_forget)
void octavo_forget(WebVolume* volume, double most_bytes) {
  volume->source().shrink_to(static_cast<std::uint64_t>(most_bytes));
}

OCTAVO_EXPORT(octavo_plan_opening)
const double* octavo_plan_opening(WebVolume* volume) {
  return keep(volume->plan_opening());
}

OCTAVO_EXPORT(octavo_open)
void octavo_open(WebVolume* volume, double cache_bytes) {
  volume->open(static_cast<std::uint64_t>(cache_bytes));
}

OCTAVO_EXPORT(octavo_describe)
const char* octavo_describe(WebVolume* volume) {
  return keep(volume->description());
}

OCTAVO_EXPORT(octavo_metadata)
const char* octavo_metadata(WebVolume* volume) { return keep(volume->metadata()); }

OCTAVO_EXPORT(octavo_plan_pages)
const double* octavo_plan_pages(WebVolume* volume, const double* box, int level) {
  return keep(volume->plan_pages(box_of(box), level));
}

OCTAVO_EXPORT(octavo_plan)
const double* octavo_plan(WebVolume* volume, const double* box, int level) {
  return keep(volume->plan_box(box_of(box), level));
}

OCTAVO_EXPORT(octavo_read)
void octavo_read(WebVolume* volume, const double* box, int level, void* out) {
  volume->read(box_of(box), level, out);
}

OCTAVO_EXPORT(octavo_brick_ranges)
void octavo_brick_ranges(WebVolume* volume, const double* bricks, int level, double* min,
                         double* max) {
  volume->brick_ranges(box_of(bricks), level, min, max);
}

OCTAVO_EXPORT(octavo_plan_thumbnail)
const double* octavo_plan_thumbnail(WebVolume* volume) {
  return keep(volume->plan_thumbnail());
}

OCTAVO_EXPORT(octavo_thumbnail_bytes)
double octavo_thumbnail_bytes(WebVolume* volume) {
  return static_cast<double>(volume->thumbnail_bytes());
}

OCTAVO_EXPORT(octavo_thumbnail)
const std::uint8_t* octavo_thumbnail(WebVolume* volume) {
  static octavo::Bytes picture;
  picture = volume->thumbnail();
  return picture.data();
}

/// The o-code of the cube of a level around a voxel of a volume: digits and markers.
OCTAVO_EXPORT(octavo_o_code)
const char* octavo_o_code(const double* size, const double* voxel, int level) {
  const auto at = [](const double* values, int i) { return static_cast<std::int64_t>(values[i]); };
  const int n = octavo::universe_level({at(size, 0), at(size, 1), at(size, 2)});
  const octavo::Index3 place{at(voxel, 0), at(voxel, 1), at(voxel, 2)};
  return keep(octavo::to_mixed_octal(octavo::cube_at(place, std::clamp(level, 0, n)), n));
}

/// Red, green and blue from the lowest byte on.
OCTAVO_EXPORT(octavo_label_color)
std::uint32_t octavo_label_color(double label) {
  const octavo::LabelColor color = octavo::label_color(static_cast<std::int64_t>(label));
  return color[0] | std::uint32_t{color[1]} << 8 | std::uint32_t{color[2]} << 16;
}
