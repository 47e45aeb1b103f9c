#include "octavo/octree/mask_tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "octavo/core/levels.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

namespace {

// The tree of a box, made top-down: only cubes that the faces of the box cut are entered.
class BoxTree {
 public:
  explicit BoxTree(const Box& box, int rank_count) : box_(box) {
    arrays_.cubes.resize(static_cast<std::size_t>(rank_count));
  }

  MaskArrays make() {
    const int rank = static_cast<int>(arrays_.cubes.size()) - 1;
    const MaskCube root = cube(rank, {0, 0, 0});
    arrays_.cubes.back().push_back(root);
    return std::move(arrays_);
  }

 private:
  MaskCube cube(int rank, const Index3& corner) {
    MaskCube made;
    std::vector<MaskCube>* below =
        rank > 0 ? &arrays_.cubes[static_cast<std::size_t>(rank) - 1] : nullptr;
    made.first = below != nullptr ? below->size() : arrays_.words.size();
    for (int bit = 0; bit < 64; ++bit) {
      const Box part = child_box(corner, bit, child_side(rank));
      const std::uint64_t here = std::uint64_t{1} << bit;
      if (box_.contains(part)) {
        made.full |= here;
      } else if (!intersection(box_, part).is_empty()) {
        made.mixed |= here;
        if (below != nullptr) {
          const MaskCube child = cube(rank - 1, part.lo);
          below->push_back(child);
        } else {
          arrays_.words.push_back(word(part.lo));
        }
      }
    }
    return made;
  }

  std::uint64_t word(const Index3& corner) const {
    std::uint64_t bits = 0;
    for (int bit = 0; bit < 64; ++bit) {
      if (box_.contains(child_box(corner, bit, 1).lo)) bits |= std::uint64_t{1} << bit;
    }
    return bits;
  }

  Box box_;
  MaskArrays arrays_;
};

// Proves the sub-tree of `cube`; `ends` holds, by rank of children + 1, where the next children
// must begin (0: words).
bool is_valid_cube(const MaskTree& tree, int rank, const MaskCube& cube,
                   std::vector<std::uint64_t>& ends) {
  std::uint64_t& end = ends[static_cast<std::size_t>(rank)];
  const std::size_t stored = rank == 0 ? tree.words().size() : tree.cubes(rank - 1).size();
  if ((cube.full & cube.mixed) != 0 || cube.first != end || cube.end() > stored) return false;
  end = cube.end();
  for (std::uint64_t i = cube.first; i < cube.end(); ++i) {
    if (rank == 0) {
      if (tree.words()[i] == 0 || tree.words()[i] == kFullWord) return false;
      continue;
    }
    const MaskCube& child = tree.cubes(rank - 1)[i];
    if (child.is_empty() || child.is_full()) return false;
    if (!is_valid_cube(tree, rank - 1, child, ends)) return false;
  }
  return true;
}

bool lies_in_volume(const MaskTree& tree) {
  const Box volume = box_of(tree.size());
  bool is_inside = true;
  for_each_leaf(tree,
                [&](const OCode& leaf) { is_inside = is_inside && volume.contains(box_of(leaf)); });
  return is_inside;
}

// Counts full octants and the full children outside them.
void count_leaves(std::uint64_t full, std::size_t level, std::vector<std::int64_t>& counts) {
  const std::int64_t octants = std::popcount(full_octants(full));
  counts[level + 1] += octants;
  counts[level] += std::popcount(full) - 8 * octants;
}

}  // namespace

MaskTree::MaskTree(const Size3& size) : size_(size) {
  checked_voxel_count(size);
  arrays_.cubes.resize(static_cast<std::size_t>(rank_count_for(size)));
  arrays_.cubes.back().emplace_back();
}

MaskTree::MaskTree(const Size3& size, MaskArrays arrays)
    : size_(size), arrays_(std::move(arrays)) {}

int MaskTree::rank_count_for(const Size3& size) {
  const std::int64_t longest = std::max({size.x, size.y, size.z});
  int ranks = kMinRanks;
  while (child_side(ranks) < longest) ++ranks;
  return ranks;
}

bool MaskTree::contains(const Index3& voxel) const noexcept {
  if (!box_of(size_).contains(voxel)) return false;
  const std::uint64_t code = interleave(voxel);
  const MaskCube* cube = &root();
  for (int rank = rank_count() - 1;; --rank) {
    const auto bit = static_cast<int>(code >> 6 * (rank + 1) & 63);
    if ((cube->mixed >> bit & 1) == 0) return (cube->full >> bit & 1) != 0;
    const std::uint64_t place = cube->place_of(bit);
    if (rank == 0) return (arrays_.words[place] >> (code & 63) & 1) != 0;
    cube = &arrays_.cubes[static_cast<std::size_t>(rank) - 1][place];
  }
}

std::uint64_t MaskTree::voxel_count() const noexcept {
  std::uint64_t count = 0;
  for (const std::uint64_t word : arrays_.words)
    count += static_cast<unsigned>(std::popcount(word));
  for (int rank = 0; rank < rank_count(); ++rank) {
    std::uint64_t full = 0;
    for (const MaskCube& cube : cubes(rank))
      full += static_cast<unsigned>(std::popcount(cube.full));
    count += full << 6 * (rank + 1);
  }
  return count;
}

std::uint64_t MaskTree::memory_bytes() const noexcept {
  std::uint64_t bytes = arrays_.words.capacity() * sizeof(std::uint64_t);
  for (const auto& rank : arrays_.cubes) bytes += rank.capacity() * sizeof(MaskCube);
  return bytes;
}

std::uint64_t children_in_box(const Index3& corner, std::int64_t side, const Box& box) noexcept {
  std::uint64_t bits = ~std::uint64_t{0};
  for (int axis = 0; axis < 3; ++axis) {
    std::uint64_t slabs = 0;
    for (int at = 0; at < 4; ++at) {
      const std::int64_t lo = corner[axis] + at * side;
      if (lo < box.hi[axis] && lo + side > box.lo[axis]) slabs |= slab_of(axis, at);
    }
    bits &= slabs;
  }
  return bits;
}

Box box_of_children(std::uint64_t bits, const Index3& corner, std::int64_t side) noexcept {
  Box box;
  if (bits == 0) return box;
  for (int axis = 0; axis < 3; ++axis) {
    int lowest = 0;
    int highest = 3;
    while ((bits & slab_of(axis, lowest)) == 0) ++lowest;
    while ((bits & slab_of(axis, highest)) == 0) --highest;
    box.lo[axis] = corner[axis] + lowest * side;
    box.hi[axis] = corner[axis] + (highest + 1) * side;
  }
  return box;
}

bool is_valid(const MaskTree& tree) {
  if (tree.rank_count() != MaskTree::rank_count_for(tree.size())) return false;
  if (tree.cubes(tree.rank_count() - 1).size() != 1) return false;
  std::vector<std::uint64_t> ends(static_cast<std::size_t>(tree.rank_count()));
  if (!is_valid_cube(tree, tree.rank_count() - 1, tree.root(), ends)) return false;
  if (ends[0] != tree.words().size()) return false;
  for (int rank = 1; rank < tree.rank_count(); ++rank) {
    if (ends[static_cast<std::size_t>(rank)] != tree.cubes(rank - 1).size()) return false;
  }
  return lies_in_volume(tree);
}

std::vector<std::int64_t> leaf_counts(const MaskTree& tree) {
  // Level by level up to the root cube of the tree, which may lie above the volume's root level.
  std::vector<std::int64_t> counts(static_cast<std::size_t>(2 * tree.rank_count()) + 3);
  for (const std::uint64_t word : tree.words()) count_leaves(word, 0, counts);
  for (int rank = 0; rank < tree.rank_count(); ++rank) {
    for (const MaskCube& cube : tree.cubes(rank)) {
      if (cube.is_full()) {
        ++counts[static_cast<std::size_t>(2 * rank) + 4];
      } else {
        count_leaves(cube.full, static_cast<std::size_t>(2 * rank) + 2, counts);
      }
    }
  }
  counts.resize(static_cast<std::size_t>(universe_level(tree.size())) + 1);
  return counts;
}

LinearOctree to_linear_octree(const MaskTree& tree, std::int64_t value) {
  LinearOctree octree = empty_octree(universe_level(tree.size()));
  const std::vector<std::int64_t> counts = leaf_counts(tree);
  for (std::size_t level = 0; level < counts.size(); ++level) {
    octree.levels[level].codes.reserve(static_cast<std::size_t>(counts[level]));
  }
  for_each_leaf(tree, [&](const OCode& leaf) {
    octree.levels[static_cast<std::size_t>(leaf.level)].codes.push_back(leaf.code);
  });
  for (LinearOctree::Level& level : octree.levels) level.values.assign(level.codes.size(), value);
  return octree;
}

namespace {

// Writes the voxels of a word, as far as they lie in the box.
template <class T>
void fill_word(std::uint64_t word, const Index3& corner, const Box& box, T* voxels) {
  const Box cell{corner, {corner.x + 4, corner.y + 4, corner.z + 4}};
  const Box part = intersection(cell, box);
  if (part.size().x < 4) return fill_children(word, -1, corner, box, T{1}, voxels);
  const Size3 size = box.size();
  for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
    T* row = voxels + ((z - box.lo.z) * size.y + part.lo.y - box.lo.y) * size.x + part.lo.x -
             box.lo.x;
    for (std::int64_t y = part.lo.y; y < part.hi.y; ++y, row += size.x) {
      const std::uint64_t bits = word >> bit_of_place({0, y - corner.y, z - corner.z});
      const std::array<T, 4> values = {
          static_cast<T>(bits & 1), static_cast<T>(bits >> bit_of_place({1, 0, 0}) & 1),
          static_cast<T>(bits >> bit_of_place({2, 0, 0}) & 1),
          static_cast<T>(bits >> bit_of_place({3, 0, 0}) & 1)};
      std::copy_n(values.data(), 4, row);
    }
  }
}

}  // namespace

template <class T>
void fill_voxels(const MaskTree& tree, const Box& box, T* voxels) {
  std::fill_n(voxels, box.size().voxel_count(), T{0});
  visit_items(tree, box, [&](int rank, std::uint64_t place, const Index3& corner) {
    if (rank < 0) return fill_word(tree.words()[place], corner, box, voxels);
    fill_children(tree.cubes(rank)[place].full, rank, corner, box, T{1}, voxels);
  });
}

template void fill_voxels(const MaskTree&, const Box&, std::int8_t*);
template void fill_voxels(const MaskTree&, const Box&, std::uint8_t*);
template void fill_voxels(const MaskTree&, const Box&, std::int16_t*);
template void fill_voxels(const MaskTree&, const Box&, std::uint16_t*);
template void fill_voxels(const MaskTree&, const Box&, std::int32_t*);
template void fill_voxels(const MaskTree&, const Box&, std::uint32_t*);

MaskTree box_mask(const Size3& size, const Box& box) {
  checked_voxel_count(size);
  return {size, BoxTree(intersection(box, box_of(size)), MaskTree::rank_count_for(size)).make()};
}

}  // namespace octavo
