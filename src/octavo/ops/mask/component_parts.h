// The connected components of a mask of which each part saw some planes alone.
//
// A part finds the components of its planes. Those of neighboring parts that touch across the two
// planes between them are one; sizes, boxes and centers add up. Numbers are those of Components
// over the whole mask: by size, then by the first voxel in o-code order.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/work_part.h"
#include "octavo/ops/mask/components.h"

namespace octavo {

/// Voxels of one label in a row of a plane.
struct LabelRun {
  std::int64_t y = 0;
  std::int64_t begin = 0;  ///< along x, [begin, end)
  std::int64_t end = 0;
  std::uint32_t label = 0;

  friend bool operator==(const LabelRun&, const LabelRun&) = default;
};

/// What a part knows of the components in its planes.
struct PartOfComponents {
  WorkPart part;
  std::int64_t plane_count = 0;
  std::vector<Component> components;  ///< numbered in the part
  std::vector<ComponentSums> sums;
  // Its first and its last plane, by y, then x; labels of the part
  std::vector<LabelRun> first_plane;
  std::vector<LabelRun> last_plane;
};

/// What to hand on of the components of a part.
/// Requires that the mask of `found`, which has the size of the whole one, is empty outside the
/// planes of the part
PartOfComponents part_of_components(const Components& found, const WorkPart& part);

/// The components of the whole mask.
struct JoinedComponents {
  std::vector<Component> components;               ///< as Components has them
  std::vector<std::vector<std::uint32_t>> labels;  ///< [part][label in the part - 1]
};

/// Labels have 32 bits, and 0 is that of the voxels outside the mask.
inline constexpr std::uint64_t kMostComponents = (std::uint64_t{1} << 32) - 1;

/// Joins all parts, in any order.
/// most   components that there may be
/// Throws Error{invalid_argument} where parts are missing or there twice; Error{limit_exceeded} for
///        more components
/// Memory that of the components of all parts, and 24 bytes for each of them
JoinedComponents joined_components(std::span<const PartOfComponents> parts,
                                   Connectivity connectivity,
                                   std::uint64_t most = kMostComponents);

}  // namespace octavo
