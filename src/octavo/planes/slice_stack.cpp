#include "octavo/planes/slice_stack.h"

#include <cmath>
#include <utility>

namespace octavo {

std::optional<SliceStack> slice_stack_of(const PlaneSource& source) {
  if (!source.files().outline) return std::nullopt;
  return SliceStack{source.description(), source.files()};
}

SliceExcerpt excerpt_of(const PlaneFiles& files, std::int64_t first, std::int64_t end) {
  const SliceOutline& all = *files.outline;
  const FileRange range = files_of_planes(files, first, end);
  SliceExcerpt excerpt;
  excerpt.paths.assign(files.paths.begin() + range.first, files.paths.begin() + range.end);
  excerpt.outline.padding = all.padding;
  if (!all.planes.empty()) {
    excerpt.outline.planes.assign(all.planes.begin() + first, all.planes.begin() + end);
  }
  for (PlaneOrigin& plane : excerpt.outline.planes) {
    plane.below -= static_cast<std::size_t>(range.first);
  }
  if (all.tilt) {
    TiltRemoval& tilt = excerpt.outline.tilt.emplace(*all.tilt);
    tilt.shift.assign(all.tilt->shift.begin() + range.first, all.tilt->shift.begin() + range.end);
  }
  return excerpt;
}

std::string fault_of(const SliceStack& stack) {
  const auto& [paths, of_plane, outline, voxels_sha256] = stack.files;
  const Size3& size = stack.description.size;
  if (!outline) return "no outline";
  if (of_plane.size() != static_cast<std::size_t>(size.z)) return "the files of other planes";
  if (!outline->planes.empty() && outline->planes.size() != of_plane.size()) return "other planes";
  for (std::size_t z = 0; z < of_plane.size(); ++z) {
    const PlaneOrigin plane = outline->planes.empty() ? PlaneOrigin{z} : outline->planes[z];
    const bool is_mixed = plane.weight_above != 0;
    const auto first = static_cast<std::int64_t>(plane.below);
    const FileRange range{first, first + (is_mixed ? 2 : 1)};
    if (plane.is_background || !(plane.weight_above >= 0 && plane.weight_above < 1) ||
        plane.below >= paths.size() || range.end > static_cast<std::int64_t>(paths.size()) ||
        !(range == of_plane[z])) {
      return "plane " + std::to_string(z) + " of slices that are not there";
    }
  }
  if (!outline->tilt) return {};
  const auto& [degrees, shift, columns, rows, outside] = *outline->tilt;
  if (shift.size() != paths.size() || columns != size.x || rows != size.y ||
      !std::isfinite(outside)) {
    return "a tilt of another stack";
  }
  for (const auto& [x, y] : shift) {
    const bool is_within = x >= 0 && y >= 0 && x < static_cast<double>(columns) &&
                           y < static_cast<double>(rows);
    if (!is_within) return "slices beyond the canvas";
  }
  return {};
}

}  // namespace octavo
