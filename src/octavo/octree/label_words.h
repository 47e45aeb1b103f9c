// The labels of a brick as an octree has them: a word for each cube of 4^3 voxels.
//
// Words stand in the o-code order of the cube of 64^3 voxels that starts where the brick does; the
// bits of a word in that of its voxels (octree/mask_tree.h). A word has a part for each of its
// labels:
//
//     labels   0 3 7
//     words    0         1         2                    3 (outside)    4
//     first    0         1         2                    4              4    ..
//     parts    0: 64     1: 64     0: 56   2: 8         -              0: 64 ..    label: its bits
//
// Invariants
//   labels ascend; each is that of some voxel of the brick.
//   The parts of a word ascend by label, none is empty, and together they have the bits of those
//   voxels of the word that lie in the brick: a word outside has no parts.
// Consequences
//   Equal bricks have equal words.
//   A brick is uniform when it has one label; a word is when it has one part.
//   What an octant of the word holds is a byte of each part: votes are counted, not voxels visited.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "octavo/core/box.h"

namespace octavo {

/// The voxels of a word that have a label, which is meant by its place among those of the brick.
struct LabelWordPart {
  std::uint32_t label = 0;
  std::uint64_t bits = 0;

  bool operator==(const LabelWordPart&) const = default;
};

/// Kept for the next brick so that its memory is reused.
struct LabelWords {
  static constexpr std::size_t kCount = 4096;

  std::vector<std::int64_t> labels;
  std::array<std::uint32_t, kCount + 1> first{};  ///< of the parts of each word, and their end
  std::vector<LabelWordPart> parts;

  bool operator==(const LabelWords&) const = default;
  bool is_uniform() const noexcept { return labels.size() == 1; }
  std::span<const LabelWordPart> parts_of(std::size_t word) const noexcept {
    return {parts.data() + first[word], parts.data() + first[word + 1]};
  }
};

/// Makes `words` a brick of `size`, at most 64 voxels a side, whose voxels all have one label.
void fill_words(const Size3& size, std::int64_t label, LabelWords& words);

/// Replaces the labels in `parts`, places in `all`, by places in `labels`, which become those that
/// occur. Parts of a word that ascended still do.
void choose_labels(std::span<const std::int64_t> all, LabelWords& words);

}  // namespace octavo
