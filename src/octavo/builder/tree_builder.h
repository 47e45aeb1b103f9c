// Octrees in, one sealed file out: masks and label maps that stand in memory as trees.
//
// The file is that of the voxels read plane by plane (builder.h), byte for byte, but no plane is
// made. The tree says which bricks have one label: these are noted in the index with their label
// for the next tier, whole sub-trees of them at a time. Only bricks of several labels are taken out
// of the tree, as words, encoded, decoded again and compared; and those that a model is trained on.
//
//     tree -> cells of 64^3: one label  ------------------------------> index, parents
//                            several  -> words -> encoder -> decoder -> segments
//
// Models of the next groups are trained while a group is encoded. The file does not depend on the
// number of threads. Memory is that of the threads, not of the volume.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/builder/builder.h"
#include "octavo/core/progress.h"
#include "octavo/core/volume.h"
#include "octavo/file/storage/storage.h"
#include "octavo/octree/label_tree.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// A tree and what else a file says of its voxels: the size is that of the tree, the type holds its
/// labels, the kind does not matter. Both outlive the work on them.
struct DescribedMask {
  const MaskTree& tree;
  const VolumeDescription& description;
};
struct DescribedLabels {
  const LabelTree& tree;
  const VolumeDescription& description;
};

struct TreeBuildOptions {
  bool overwrite = false;
  /// What becomes of an interrupted build of the same file; a build of a tree leaves none and
  /// continues none.
  Interrupted interrupted = Interrupted::reject;
  bool has_thumbnail = false;  ///< as WriterOptions::has_thumbnail
  int threads = 0;  ///< 0: all cores
  /// 0: no limit; otherwise Error{limit_exceeded} before work starts when the need is above it.
  std::uint64_t max_memory_bytes = 0;
  std::string progress_name = "build";  ///< of the work, for Progress::begin
};

/// Builds `path` from a mask, 1 inside and 0 outside, or from a label map. Progress is counted in
/// planes.
/// Throws what the storage throws, Error{cancelled}, Error{internal} when a brick does not decode
///        to its words, Error{invalid_argument} for a size, a type or labels that do not fit the
///        tree, for float32 and for Interrupted::resume; in every case nothing but a complete file
///        stands under `path`
/// Memory tree_build_memory_bytes beside the tree
/// Source thesis 2.3, 2.4
BuildResult build_mask_file(const DescribedMask& mask, Storage& storage, const std::string& path,
                            const TreeBuildOptions& options, Progress& progress);
BuildResult build_label_file(const DescribedLabels& labels, Storage& storage,
                             const std::string& path, const TreeBuildOptions& options,
                             Progress& progress);

/// Memory that a build of a tree will need besides it, bytes.
std::uint64_t tree_build_memory_bytes(const VolumeDescription& description, int threads);

}  // namespace octavo
