// Levels whose details are not coded: interpolated from the next one.
//
// Of a file that keeps details down to level K the bricks of tier 0 are coded as if they began
// there. The levels below are made by the same splits as ever, but each detail is what the means
// around its pair predict:
//
//      means       M-2   M-1    m    M+1   M+2      d = (14 (M-1 - M+1) - 3 (M-2 - M+2)) / 32,
//                              / \                      within the room that the range leaves
//      samples                a   b                 their rounded mean is m, whatever d is
//
// A straight line goes through as it was. The two weights are nearly those that fit the details of
// CT and MR best: scans are sharper than the smoothest curve through their means. Beyond the faces
// of a brick its last means repeat: bricks stay independent, and a slope is flatter there.
//
// Source  thesis 3.4, 3.5 (Fig. 3.5)
#pragma once

#include <cstddef>
#include <vector>

#include "octavo/codec/grey/grey_brick.h"
#include "octavo/codec/grey/grey_voxels.h"

namespace octavo::grey {

/// The finest in-brick level of a brick that has details.
int detailed_level(const Parameters& p, const BrickShape& shape);

/// The brick that begins at in-brick level `level` of this one.
BrickShape shape_from(const BrickShape& shape, int level);

/// The samples that a brick begins with.
template <class Sample>
const std::vector<Sample>& finest_samples(const AnalyzedBrick<Sample>& brick) {
  for (const std::vector<Sample>& samples : brick.steps.front()) {
    if (!samples.empty()) return samples;
  }
  return brick.coarsest;
}

/// The same as voxels, dense along the brick's own axes.
/// size  of the samples, along the codec's axes
template <class Sample>
std::vector<std::byte> finest_voxels(const AnalyzedBrick<Sample>& brick, const Size3& size,
                                     const VoxelWriter& writer) {
  const Sample* const samples = finest_samples(brick).data();
  Size3 own;
  for (int place = 0; place < 3; ++place) {
    own[writer.order[static_cast<std::size_t>(place)]] = size[place];
  }
  std::vector<std::byte> voxels(
      static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(writer.type)));
  writer.write(size,
               [&](std::int64_t y, std::int64_t z) { return samples + (z * size.y + y) * size.x; },
               dense_target(voxels.data(), own));
  return voxels;
}

/// Brings the samples in the work space from in-brick level `from` down to level `to`.
template <class Sample>
void interpolate_levels(Workspace<Sample>& work, const BrickShape& shape, const SampleScale& scale,
                        int from, int to);

}  // namespace octavo::grey
