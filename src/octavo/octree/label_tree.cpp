#include "octavo/octree/label_tree.h"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <utility>

#include "octavo/core/levels.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

namespace {

std::size_t index(int rank) { return static_cast<std::size_t>(rank); }

// Proves a tree part by part; later parts read what earlier ones have proven to be there.
class Proof {
 public:
  explicit Proof(const LabelTree& tree) : tree_(tree), arrays_(tree.arrays()) {}

  bool holds() {
    return has_lengths() && has_palettes() && has_words() && has_cubes() && has_all_labels() &&
           lies_in_volume();
  }

 private:
  bool has_lengths() const {
    const int ranks = tree_.rank_count();
    if (ranks != MaskTree::rank_count_for(tree_.size())) return false;
    if (arrays_.values.size() != arrays_.cubes.size()) return false;
    if (tree_.cubes(ranks - 1).size() != 1) return false;
    if (arrays_.palettes.size() != tree_.word_count()) return false;
    for (std::size_t p = 0; p + 1 < arrays_.planes.size(); ++p) {
      const RankedBits& deeper = arrays_.deeper[p];
      const std::uint64_t expected = arrays_.planes[p + 1].empty() ? 0 : arrays_.planes[p].size();
      if (deeper.size() != expected || deeper.count() != arrays_.planes[p + 1].size()) {
        return false;
      }
    }
    const std::vector<std::uint64_t>& starts = arrays_.palette_starts;
    return !starts.empty() && starts.front() == 0 &&
           starts.back() == arrays_.palette_labels.size() &&
           std::is_sorted(starts.begin(), starts.end());
  }

  bool has_palettes() {
    is_used_.assign(arrays_.labels.size(), false);
    std::vector<std::uint32_t> before;
    for (std::uint32_t palette = 0; palette < tree_.palette_count(); ++palette) {
      std::vector<std::uint32_t> labels;
      for (std::uint64_t i = 0; i < tree_.palette_size(palette); ++i) {
        labels.push_back(tree_.palette_label(palette, i));
      }
      if (labels.size() < 2 || labels.size() > 64 || labels.back() >= arrays_.labels.size()) {
        return false;
      }
      const bool is_ascending =
          std::adjacent_find(labels.begin(), labels.end(), std::greater_equal<>()) == labels.end();
      const bool is_behind =
          labels.size() != before.size() ? labels.size() > before.size() : labels > before;
      if (!is_ascending || !is_behind) return false;
      for (const std::uint32_t label : labels) is_used_[label] = true;
      before = std::move(labels);
    }
    return true;
  }

  bool has_words() const {
    std::vector<bool> is_palette_used(tree_.palette_count());
    for (std::uint64_t word = 0; word < tree_.word_count(); ++word) {
      const std::uint32_t palette = tree_.palette_of(word);
      if (palette >= tree_.palette_count() || !has_planes(word, palette)) return false;
      is_palette_used[palette] = true;
      std::uint64_t all = 0;
      bool has_each = true;
      tree_.visit_word(word, [&](std::uint32_t, std::uint64_t bits) {
        has_each = has_each && bits != 0;
        all |= bits;
      });
      if (!has_each || all != kFullWord) return false;
    }
    return std::find(is_palette_used.begin(), is_palette_used.end(), false) ==
           is_palette_used.end();
  }

  // Whether a word stands in as many planes as its palette asks for.
  bool has_planes(std::uint64_t word, std::uint32_t palette) const {
    const int count = label_planes(tree_.palette_size(palette));
    for (int p = 0; p < kMostLabelPlanes - 1; ++p) {
      const RankedBits& deeper = arrays_.deeper[index(p)];
      const bool goes_on = deeper.size() != 0 && deeper[word];
      if (goes_on != (count > p + 1)) return false;
      if (!goes_on) return true;
      word = deeper.rank(word);
    }
    return true;
  }

  bool has_cubes() {
    ends_.assign(index(tree_.rank_count()), 0);
    value_ends_.assign(index(tree_.rank_count()), 0);
    if (!has_cube(tree_.rank_count() - 1, tree_.root())) return false;
    for (int rank = 0; rank < tree_.rank_count(); ++rank) {
      if (ends_[index(rank)] != stored_below(rank)) return false;
      if (value_ends_[index(rank)] != arrays_.values[index(rank)].size()) return false;
    }
    return true;
  }

  std::uint64_t stored_below(int rank) const {
    return rank == 0 ? tree_.word_count() : tree_.cubes(rank - 1).size();
  }

  bool has_cube(int rank, const LabelCube& cube) {
    if (!has_runs(rank, cube)) return false;
    std::uint64_t& end = ends_[index(rank)];
    if (cube.first != end || cube.end() > stored_below(rank)) return false;
    end = cube.end();
    if (rank == 0) return true;
    for (std::uint64_t i = cube.first; i < cube.end(); ++i) {
      const LabelCube& child = tree_.cubes(rank - 1)[i];
      if (child.is_uniform() || !has_cube(rank - 1, child)) return false;
    }
    return true;
  }

  bool has_runs(int rank, const LabelCube& cube) {
    const std::uint64_t uniform = ~cube.mixed;
    const PackedNumbers& values = arrays_.values[index(rank)];
    std::uint64_t& end = value_ends_[index(rank)];
    if ((cube.starts & cube.mixed) != 0 || (uniform & -uniform & ~cube.starts) != 0) return false;
    if (cube.first_value != end || cube.end_value() > values.size()) return false;
    end = cube.end_value();
    for (std::uint64_t i = cube.first_value; i < end; ++i) {
      if (values[i] >= arrays_.labels.size()) return false;
      if (i > cube.first_value && values[i] == values[i - 1]) return false;
      is_used_[values[i]] = true;
    }
    return true;
  }

  bool has_all_labels() const {
    const std::vector<std::int64_t>& labels = arrays_.labels;
    return std::adjacent_find(labels.begin(), labels.end(), std::greater_equal<>()) ==
               labels.end() &&
           std::find(is_used_.begin(), is_used_.end(), false) == is_used_.end();
  }

  bool lies_in_volume() const {
    const Box volume = box_of(tree_.size());
    bool is_inside = true;
    for_each_leaf(tree_, [&](const OCode& leaf, std::uint32_t) {
      is_inside = is_inside && volume.contains(box_of(leaf));
    });
    return is_inside;
  }

  const LabelTree& tree_;
  const LabelArrays& arrays_;
  std::vector<bool> is_used_;              // by label
  std::vector<std::uint64_t> ends_;        // by rank, where the next children must begin
  std::vector<std::uint64_t> value_ends_;  // and the next values
};

// Where the voxels of a word stand in [z][y][x] of 4^3, by bit.
constexpr std::array<std::uint8_t, 64> kVoxelPlaces = [] {
  std::array<std::uint8_t, 64> places{};
  for (std::size_t bit = 0; bit < 64; ++bit) {
    const Index3 at = place_of_bit(static_cast<int>(bit));
    places[bit] = static_cast<std::uint8_t>(16 * at.z + 4 * at.y + at.x);
  }
  return places;
}();

// Writes the voxels of a box that are not 0, cube by cube.
template <class T>
class Filler {
 public:
  Filler(const LabelTree& tree, const Box& box, T* voxels)
      : tree_(tree), box_(box), voxels_(voxels) {}

  void fill_cube(int rank, const LabelCube& cube, const Index3& corner) {
    const std::uint64_t inside = children_in_box(corner, child_side(rank), box_);
    tree_.visit_runs(rank, cube, [&](std::uint32_t label, std::uint64_t bits) {
      const T value = value_of(label);
      if (value != 0) fill_children(bits & inside, rank, corner, box_, value, voxels_);
    });
    for (std::uint64_t left = cube.mixed & inside; left != 0; left &= left - 1) {
      const int bit = std::countr_zero(left);
      const Index3 child = child_box(corner, bit, child_side(rank)).lo;
      const std::uint64_t place = cube.place_of(bit);
      if (rank > 0) {
        fill_cube(rank - 1, tree_.cubes(rank - 1)[place], child);
      } else {
        fill_word(place, child);
      }
    }
  }

 private:
  void fill_word(std::uint64_t place, const Index3& corner) {
    const std::uint32_t palette = tree_.palette_of(place);
    if (tree_.palette_size(palette) == 2) {
      const T low = value_of(tree_.palette_label(palette, 0));
      const T high = value_of(tree_.palette_label(palette, 1));
      const std::uint64_t is_high = tree_.planes_of(place)[0];
      write_rows(corner, [&](std::int64_t y, std::int64_t z) {
        const std::uint64_t row = is_high >> bit_of_place({0, y, z});
        const auto voxel = [&](std::int64_t x) {
          return (row >> bit_of_place({x, 0, 0}) & 1) != 0 ? high : low;
        };
        return std::array<T, 4>{voxel(0), voxel(1), voxel(2), voxel(3)};
      });
      return;
    }
    std::array<T, 64> values;  // [z][y][x]
    tree_.visit_word(place, [&](std::uint32_t label, std::uint64_t bits) {
      for (; bits != 0; bits &= bits - 1) {
        values[kVoxelPlaces[static_cast<std::size_t>(std::countr_zero(bits))]] = value_of(label);
      }
    });
    write_rows(corner, [&](std::int64_t y, std::int64_t z) {
      std::array<T, 4> row;
      std::copy_n(values.data() + 16 * z + 4 * y, 4, row.data());
      return row;
    });
  }

  // Writes the rows of a word, which row_at(y, z) gives, as far as they lie in the box.
  template <class RowAt>
  void write_rows(const Index3& corner, RowAt row_at) {
    const Box part =
        intersection({corner, {corner.x + 4, corner.y + 4, corner.z + 4}}, box_);
    const Size3 size = box_.size();
    const std::int64_t before = part.lo.x - corner.x;
    const std::int64_t count = part.hi.x - part.lo.x;
    for (std::int64_t z = part.lo.z; z < part.hi.z; ++z) {
      T* to = voxels_ + ((z - box_.lo.z) * size.y + part.lo.y - box_.lo.y) * size.x + part.lo.x -
              box_.lo.x;
      for (std::int64_t y = part.lo.y; y < part.hi.y; ++y, to += size.x) {
        const std::array<T, 4> row = row_at(y - corner.y, z - corner.z);
        if (count == 4) std::copy_n(row.data(), 4, to);
        else std::copy_n(row.data() + before, count, to);
      }
    }
  }

  T value_of(std::uint32_t label) const { return static_cast<T>(tree_.labels()[label]); }

  const LabelTree& tree_;
  const Box box_;
  T* const voxels_;
};

}  // namespace

std::uint64_t memory_bytes(const LabelArrays& arrays) noexcept {
  std::uint64_t bytes = arrays.labels.capacity() * sizeof(std::int64_t);
  for (const auto& rank : arrays.cubes) bytes += rank.capacity() * sizeof(LabelCube);
  for (const PackedNumbers& values : arrays.values) bytes += values.memory_bytes();
  for (const auto& plane : arrays.planes) bytes += plane.capacity() * sizeof(std::uint64_t);
  for (const RankedBits& deeper : arrays.deeper) bytes += deeper.memory_bytes();
  bytes += arrays.palette_starts.capacity() * sizeof(std::uint64_t);
  return bytes + arrays.palettes.memory_bytes() + arrays.palette_labels.memory_bytes();
}

LabelTree::LabelTree(const Size3& size) : size_(size) {
  checked_voxel_count(size);
  const std::size_t ranks = index(MaskTree::rank_count_for(size));
  arrays_.labels = {0};
  arrays_.cubes.resize(ranks);
  arrays_.cubes.back().push_back({0, 1, 0, 0});
  arrays_.values.resize(ranks);
  arrays_.values.back() = PackedNumbers(1, 0);
  arrays_.palette_starts = {0};
}

LabelTree::LabelTree(const Size3& size, LabelArrays arrays)
    : size_(size), arrays_(std::move(arrays)) {}

std::int64_t LabelTree::label_at(const Index3& voxel) const noexcept {
  if (!box_of(size_).contains(voxel)) return 0;
  const std::uint64_t code = interleave(voxel);
  const LabelCube* cube = &root();
  for (int rank = rank_count() - 1;; --rank) {
    const auto bit = static_cast<int>(code >> 6 * (rank + 1) & 63);
    if ((cube->mixed >> bit & 1) == 0) return arrays_.labels[label_of_child(rank, *cube, bit)];
    const std::uint64_t place = cube->place_of(bit);
    if (rank > 0) {
      cube = &arrays_.cubes[index(rank) - 1][place];
      continue;
    }
    const std::uint32_t palette = palette_of(place);
    const int planes = label_planes(palette_size(palette));
    std::uint64_t entry = arrays_.planes[0][place] >> (code & 63) & 1;
    std::uint64_t at = place;
    for (int p = 1; p < planes; ++p) {
      at = arrays_.deeper[index(p) - 1].rank(at);
      entry |= (arrays_.planes[index(p)][at] >> (code & 63) & 1) << p;
    }
    return arrays_.labels[palette_label(palette, entry)];
  }
}

std::array<std::uint64_t, kMostLabelPlanes> LabelTree::planes_of(
    std::uint64_t word) const noexcept {
  std::array<std::uint64_t, kMostLabelPlanes> planes{arrays_.planes[0][word]};
  const int count = label_planes(palette_size(palette_of(word)));
  for (int p = 1; p < count; ++p) {
    word = arrays_.deeper[index(p) - 1].rank(word);
    planes[index(p)] = arrays_.planes[index(p)][word];
  }
  return planes;
}

bool is_valid(const LabelTree& tree) { return Proof(tree).holds(); }

std::vector<std::uint64_t> voxel_counts(const LabelTree& tree) {
  std::vector<std::uint64_t> counts(tree.labels().size());
  for (int rank = 0; rank < tree.rank_count(); ++rank) {
    for (const LabelCube& cube : tree.cubes(rank)) {
      tree.visit_runs(rank, cube, [&](std::uint32_t label, std::uint64_t bits) {
        counts[label] += static_cast<std::uint64_t>(std::popcount(bits)) << 6 * (rank + 1);
      });
    }
  }
  for (std::uint64_t word = 0; word < tree.word_count(); ++word) {
    tree.visit_word(word, [&](std::uint32_t label, std::uint64_t bits) {
      counts[label] += static_cast<std::uint64_t>(std::popcount(bits));
    });
  }
  // All that is not in the volume was counted as 0.
  const auto zero = std::lower_bound(tree.labels().begin(), tree.labels().end(), 0);
  if (zero != tree.labels().end() && *zero == 0) {
    std::uint64_t& count = counts[static_cast<std::size_t>(zero - tree.labels().begin())];
    count += static_cast<std::uint64_t>(tree.size().voxel_count());
    count -= std::uint64_t{64} << 6 * tree.rank_count();
  }
  return counts;
}

std::vector<std::int64_t> leaf_counts(const LabelTree& tree) {
  std::vector<std::int64_t> counts(static_cast<std::size_t>(universe_level(tree.size())) + 1);
  for_each_leaf(tree, [&](const OCode& leaf, std::uint32_t) { ++counts[index(leaf.level)]; });
  return counts;
}

LinearOctree to_linear_octree(const LabelTree& tree) {
  LinearOctree octree = empty_octree(universe_level(tree.size()));
  const std::vector<std::int64_t> counts = leaf_counts(tree);
  for (std::size_t level = 0; level < counts.size(); ++level) {
    octree.levels[level].codes.reserve(static_cast<std::size_t>(counts[level]));
    octree.levels[level].values.reserve(static_cast<std::size_t>(counts[level]));
  }
  for_each_leaf(tree, [&](const OCode& leaf, std::uint32_t label) {
    LinearOctree::Level& level = octree.levels[index(leaf.level)];
    level.codes.push_back(leaf.code);
    level.values.push_back(tree.labels()[label]);
  });
  return octree;
}

template <class T>
void fill_voxels(const LabelTree& tree, const Box& box, T* voxels) {
  std::fill_n(voxels, box.size().voxel_count(), T{0});
  Filler<T>(tree, box, voxels).fill_cube(tree.rank_count() - 1, tree.root(), {0, 0, 0});
}

template void fill_voxels(const LabelTree&, const Box&, std::int8_t*);
template void fill_voxels(const LabelTree&, const Box&, std::uint8_t*);
template void fill_voxels(const LabelTree&, const Box&, std::int16_t*);
template void fill_voxels(const LabelTree&, const Box&, std::uint16_t*);
template void fill_voxels(const LabelTree&, const Box&, std::int32_t*);
template void fill_voxels(const LabelTree&, const Box&, std::uint32_t*);
template void fill_voxels(const LabelTree&, const Box&, std::int64_t*);

}  // namespace octavo
