// Which labels of a label map lie beside each other, and along how much of their surface.
//
// Bricks are taken on all threads, with one voxel around each. A brick of one label among bricks of
// the same label is settled from the index.
//
// Source  thesis 1.2
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/reader.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

/// Two labels with voxels that are neighbors.
struct LabelContact {
  std::int64_t first = 0;  ///< the smaller of the two
  std::int64_t second = 0;
  std::array<std::uint64_t, 3> face_pairs{};  ///< pairs of voxels with a face across x, y, z
  std::uint64_t voxel_pairs = 0;              ///< all pairs of neighbors, by any of their parts

  bool operator==(const LabelContact&) const = default;
};

/// The pairs of labels other than 0 that touch, ascending. Uses the threads of the calling task
/// arena; the result does not depend on their number.
/// connectivity  which voxels are neighbors
/// Throws  what the reader throws, Error{cancelled}; Error{invalid_argument} for a grey volume
/// Memory  a brick per thread with 8 bytes per voxel; 48 bytes per pair of labels and thread
std::vector<LabelContact> label_contacts(const FileReader& labels, Connectivity connectivity,
                                         Progress& progress);

}  // namespace octavo
