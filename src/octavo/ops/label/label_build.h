// Label trees from voxels, from the bricks of a file, and from masks.
//
// Cubes of 64^3 voxels are folded one by one on all threads and joined, so that memory is that of
// the tree and a cube per thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/octree/label_tree.h"
#include "octavo/ops/label/label_masks.h"
#include "octavo/ops/mask/mask_build.h"

namespace octavo {

/// The labels of a level. At level 0 bricks of one label are not decoded. Uses the threads of the
/// calling task arena; advances `progress` by planes.
/// windows    labels in none of them count as 0
/// max_bytes  0: no limit; otherwise Error{limit_exceeded} when the tree grows beyond it
/// Throws what the reader throws, Error{cancelled}; Error{invalid_argument} for a level that is not
///        there and for a grey volume
LabelTree labels_of_file(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                         Progress& progress, std::uint64_t max_bytes = 0);

/// The labels of a volume in memory. Uses the threads of the calling task arena.
/// Throws Error{limit_exceeded} on a bad size; Error{invalid_argument} for float32
LabelTree make_labels(const BrickView& volume);

/// The label map that has the label of a mask in all its voxels and 0 elsewhere. Uses the threads
/// of the calling task arena.
/// masks  of `size`, in any order of labels; several may have one label
/// Throws Error{limit_exceeded} on a bad size; Error{invalid_argument} when a mask has another size
///        or the label 0, or a voxel lies in two of them
LabelTree labels_of_masks(const Size3& size, std::span<const LabelMask> masks);

}  // namespace octavo
