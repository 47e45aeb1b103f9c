// How much of a brick, or of a part of it, is decoded for a request and kept.
//
// Planes are decoded one after the other along one axis. Who asks for few of them first gets no
// more than these and what lies in front; who asks for further ones gets all. What is kept is a
// dense array of the first planes: its length tells how many. Of a part, who asks for few planes
// along another axis first gets these alone, which are kept by themselves.
#pragma once

#include <cstdint>

#include "octavo/core/box.h"
#include "octavo/file/box_target.h"

namespace octavo {

/// Requests of so few planes get no more planes than they need of what nobody has asked for before:
/// on average that leaves out half of the last split, which makes half of the samples.
inline constexpr std::int64_t kFewPlanes = 4;

/// What is kept of a box: as many of its planes along an axis, from the first on, as there are
/// bytes.
inline Box held_of(const Box& all, int axis, std::uint64_t bytes, std::size_t voxel_bytes) {
  const Size3 size = all.size();
  const auto plane = static_cast<std::uint64_t>(size.voxel_count() / size[axis]) * voxel_bytes;
  Box held = all;
  held.hi[axis] = all.lo[axis] + static_cast<std::int64_t>(bytes / plane);
  return held;
}

/// What is decoded of a box for a request that meets it.
/// is_new  nothing of it is kept
inline Box decoded_for(const Box& request, const Box& all, int axis, bool is_new) {
  Box own = all;
  if (is_new && request.size()[axis] <= kFewPlanes) {
    own.hi[axis] = intersection(request, all).hi[axis];
  }
  return own;
}

/// Whether voxels may be written there as what they are.
inline bool is_aligned(const BoxTarget& out) {
  return reinterpret_cast<std::uintptr_t>(out.bytes) % out.voxel_bytes == 0;
}

}  // namespace octavo
