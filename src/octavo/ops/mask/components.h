// Connected components of a mask, found on its tree.
//
// Every stored word falls into parts connected inside it, and so do the full children of every
// cube; most fall into one. Parts are joined with those of the words and cubes that touch them, and
// a full child with whatever touches it below its neighbors, so that each pair of touching items
// is looked at once. Work and memory follow the surface of the mask, not its volume.
//
// Source  thesis 1.2; union-find with links to the smaller index: Rem's algorithm in Dijkstra, A
//         Discipline of Programming, 1976
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "octavo/octree/mask_tree.h"
#include "octavo/ops/mask/word_neighbors.h"

namespace octavo {

/// One connected component.
struct Component {
  std::uint64_t voxel_count = 0;
  Box box;                          ///< its bounding box
  std::array<double, 3> centroid{};  ///< mean of the positions of its voxels, x, y, z
};

/// Of a component, without any rounding: what components of parts of a mask add up.
struct ComponentSums {
  std::uint64_t first_code = std::numeric_limits<std::uint64_t>::max();  ///< of its first voxel
  std::array<__int128, 3> doubled{};  ///< twice the sum of the positions of its voxels

  void add(const ComponentSums& more) {
    first_code = std::min(first_code, more.first_code);
    for (std::size_t axis = 0; axis < 3; ++axis) doubled[axis] += more.doubled[axis];
  }
  std::array<double, 3> centroid(std::uint64_t voxel_count) const {
    std::array<double, 3> center;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      center[axis] =
          static_cast<double>(doubled[axis]) / (2 * static_cast<double>(voxel_count));
    }
    return center;
  }
};

/// The components of one mask, the largest first; among equals the one with the first voxel in
/// o-code order. The mask must outlive this.
/// Memory  4 bytes per stored word and cube, 12 per part of one, 144 per component, and while these
///         are counted 152 more of each
class Components {
 public:
  /// Uses the threads of the calling task arena; the result does not depend on their number.
  /// max_bytes  0: no limit; otherwise Error{limit_exceeded} when parts and components need more
  /// Throws Error{limit_exceeded} for a mask of 2^32 parts or more.
  Components(const MaskTree& mask, Connectivity connectivity, std::uint64_t max_bytes = 0);

  const std::vector<Component>& components() const { return components_; }

  /// Of each of them.
  const std::vector<ComponentSums>& sums() const { return sums_; }

  /// That they are of.
  const MaskTree& mask() const { return mask_; }

  /// Bytes that all this takes, the mask left out.
  std::uint64_t memory_bytes() const noexcept;

  /// 1 for a voxel of the largest component, 2 for the next, ...; 0 outside the mask.
  /// O(ranks), thread-safe
  std::uint32_t label_of(const Index3& voxel) const noexcept;

  /// The voxels of the components for which keep[label - 1] holds.
  /// Requires keep.size() == components().size()
  MaskTree select(const std::vector<bool>& keep) const;

  /// Calls visit(label, bits) for the parts of the word at `place` (rank -1), or of the full
  /// children of the cube there; parts of one word may have one label.
  template <class Visit>
  void visit_parts(int rank, std::uint64_t place, Visit&& visit) const;

  /// Writes the labels of `box` to `labels`, [z][y][x] without gaps. Thread-safe.
  /// Requires a box inside the volume
  void fill_labels(const Box& box, std::uint32_t* labels) const;

 private:
  class Linker;
  class Census;
  class Selection;

  std::uint32_t first_part(int rank, std::uint64_t place) const {
    return first_parts_[static_cast<std::size_t>(rank + 1)][place];
  }
  std::uint32_t part_at(int rank, std::uint64_t place, int bit) const noexcept;
  void find_parts(std::uint64_t max_bytes);

  const MaskTree& mask_;
  Connectivity connectivity_;
  /// [rank + 1][place]: the first part of a cube's full children, or of a word (rank -1); one more
  /// entry at the end of each.
  std::vector<std::vector<std::uint32_t>> first_parts_;
  std::vector<std::uint64_t> parts_;    ///< the bits of each part
  std::vector<std::uint32_t>
      labels_;  ///< of each part; while linking, an earlier part joined to it
  std::vector<Component> components_;
  std::vector<ComponentSums> sums_;
};

// ---- implementation of the template

template <class Visit>
void Components::visit_parts(int rank, std::uint64_t place, Visit&& visit) const {
  const std::uint32_t end = first_part(rank, place + 1);
  for (std::uint32_t part = first_part(rank, place); part < end; ++part) {
    visit(labels_[part], parts_[part]);
  }
}

}  // namespace octavo
