#include "octavo/ops/label/label_masks.h"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <iterator>
#include <string>
#include <unordered_map>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/ops/label/label_build.h"
#include "octavo/ops/label/label_portions.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr MaskCube kFullCubeOfLabel{kFullWord, 0, 0};

// Calls take(code) for the cubes of 64^3 in those children of a cube of `rank` whose bits are set.
template <class Take>
void visit_below(int rank, std::uint64_t code, std::uint64_t bits, Take take) {
  const int shift = 6 * (rank - 2);
  for (; bits != 0; bits &= bits - 1) {
    const std::uint64_t child = code << 6 | static_cast<std::uint64_t>(std::countr_zero(bits));
    for (std::uint64_t i = 0; i < std::uint64_t{1} << shift; ++i) take((child << shift) + i);
  }
}

bool is_before(const MaskPart& a, const MaskPart& b) {
  return a.pieces.front().code < b.pieces.front().code;
}

// The union of some labels, cube by cube.
class Union {
 public:
  Union(const LabelTree& tree, std::span<const std::int64_t> labels)
      : tree_(tree), is_wanted_(tree.labels().size()), entries_(tree.palette_count()) {
    for (const std::int64_t label : labels) {
      const auto at = std::lower_bound(tree.labels().begin(), tree.labels().end(), label);
      if (label == 0 || at == tree.labels().end() || *at != label) continue;
      is_wanted_[static_cast<std::size_t>(at - tree.labels().begin())] = true;
    }
    for (std::uint32_t palette = 0; palette < entries_.size(); ++palette) {
      for (std::uint64_t i = 0; i < tree.palette_size(palette); ++i) {
        if (is_wanted_[tree.palette_label(palette, i)]) {
          entries_[palette] |= std::uint64_t{1} << i;
        }
      }
    }
  }

  MaskTree make() const {
    std::vector<MaskPart> parts;
    const std::vector<LabelPlace> places = label_places(
        tree_, [&](int rank, std::uint64_t code, std::uint32_t label, std::uint64_t bits) {
          if (!is_wanted_[label]) return;
          visit_below(rank, code, bits, [&](std::uint64_t below) {
            MaskPart& part = parts.emplace_back();
            part.pieces.push_back({below, kFullCubeOfLabel});
            part.below = arrays_below(1);
          });
        });
    const std::size_t full = parts.size();
    parts.resize(full + places.size());
    parallel_for(std::size_t{0}, places.size(),
                      [&](std::size_t i) { parts[full + i] = part_of(places[i]); });
    std::erase_if(parts, [](const MaskPart& part) { return part.pieces.empty(); });
    std::sort(parts.begin(), parts.end(), is_before);
    return assemble(tree_.size(), 1, parts);
  }

 private:
  // The wanted ones among the uniform children.
  std::uint64_t full_in(int rank, const LabelCube& cube) const {
    std::uint64_t full = 0;
    tree_.visit_runs(rank, cube, [&](std::uint32_t label, std::uint64_t bits) {
      if (is_wanted_[label]) full |= bits;
    });
    return full;
  }

  std::uint64_t bits_in(std::uint64_t word) const {
    const std::uint32_t palette = tree_.palette_of(word);
    const std::uint64_t size = tree_.palette_size(palette);
    std::uint64_t entries = entries_[palette];
    if (entries == 0) return 0;
    const auto planes = tree_.planes_of(word);
    std::uint64_t bits = 0;
    for (; entries != 0; entries &= entries - 1) {
      const auto entry = static_cast<std::uint64_t>(std::countr_zero(entries));
      bits |= LabelTree::bits_of(planes, size, entry);
    }
    return bits;
  }

  MaskPart part_of(const LabelPlace& at) const {
    MaskPart part;
    part.below = arrays_below(1);
    const LabelCube& cube = tree_.cubes(1)[at.place];
    MaskCube made{full_in(1, cube), 0, 0};
    std::uint64_t child = cube.first;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      add_child(cube_of(child++, part.below.words), std::countr_zero(left), made,
                part.below.cubes[0]);
    }
    if (!made.is_empty()) part.pieces.push_back({at.code, made});
    return part;
  }

  MaskCube cube_of(std::uint64_t place, std::vector<std::uint64_t>& words) const {
    const LabelCube& cube = tree_.cubes(0)[place];
    MaskCube made{full_in(0, cube), 0, words.size()};
    std::uint64_t word = cube.first;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      const std::uint64_t bits = bits_in(word++);
      if (bits == kFullWord) {
        made.full |= left & -left;
      } else if (bits != 0) {
        made.mixed |= left & -left;
        words.push_back(bits);
      }
    }
    return made;
  }

  const LabelTree& tree_;
  std::vector<bool> is_wanted_;         // by label
  std::vector<std::uint64_t> entries_;  // by palette: the wanted labels of it
};

/// What one label has in one cube of 64^3.
struct LabelMaskPart {
  std::uint32_t label = 0;
  MaskPart part;
};

// Gathers the parts of all labels.
class AllMasks {
 public:
  AllMasks(const LabelTree& tree, std::uint64_t max_bytes) : tree_(tree), max_bytes_(max_bytes) {}

  std::vector<LabelMask> make() {
    const std::vector<LabelPlace> places = label_places(
        tree_, [&](int rank, std::uint64_t code, std::uint32_t label, std::uint64_t bits) {
          if (tree_.labels()[label] == 0) return;
          visit_below(rank, code, bits, [&](std::uint64_t below) {
            LabelMaskPart& made = parts_.emplace_back();
            made.label = label;
            made.part.pieces.push_back({below, kFullCubeOfLabel});
            made.part.below = arrays_below(1);
          });
        });
    std::vector<std::vector<LabelMaskPart>> found(places.size());
    PerThread<LabelPortions> portions([this] { return LabelPortions(tree_); });
    parallel_for(std::size_t{0}, places.size(),
                      [&](std::size_t i) { found[i] = parts_of(places[i], portions.local()); });
    for (std::vector<LabelMaskPart>& parts : found) {
      parts_.insert(parts_.end(), std::make_move_iterator(parts.begin()),
                    std::make_move_iterator(parts.end()));
      parts = {};
    }
    return assembled();
  }

 private:
  std::vector<LabelMaskPart> parts_of(const LabelPlace& at, LabelPortions& portions) {
    std::vector<LabelMaskPart> parts;
    std::unordered_map<std::uint32_t, std::size_t> numbers;
    const auto part_of = [&](std::uint32_t label) -> MaskPart& {
      const auto [found, is_new] = numbers.try_emplace(label, parts.size());
      if (!is_new) return parts[found->second].part;
      LabelMaskPart& made = parts.emplace_back();
      made.label = label;
      made.part.pieces.push_back({at.code, {}});
      made.part.below = arrays_below(1);
      return made.part;
    };
    const LabelCube& cube = tree_.cubes(1)[at.place];
    tree_.visit_runs(1, cube, [&](std::uint32_t label, std::uint64_t bits) {
      if (tree_.labels()[label] != 0) part_of(label).pieces.front().cube.full |= bits;
    });
    std::uint64_t child = cube.first;
    for (std::uint64_t left = cube.mixed; left != 0; left &= left - 1) {
      for (const LabelPortion& portion : portions.in_cube(child++)) {
        MaskPart& part = part_of(portion.label);
        part.pieces.front().cube.mixed |= left & -left;
        part.below.cubes[0].push_back({portion.full, portion.mixed, part.below.words.size()});
        part.below.words.insert(part.below.words.end(), portion.words.begin(), portion.words.end());
      }
    }
    std::uint64_t bytes = 0;
    for (LabelMaskPart& part : parts) {
      part.part.below.words.shrink_to_fit();
      part.part.below.cubes[0].shrink_to_fit();
      bytes += 2 * memory_bytes(part.part);
    }
    require_memory_within(bytes_ += bytes, max_bytes_, "the masks",
                          "raise the limit, or choose labels by a range");
    return parts;
  }

  std::vector<LabelMask> assembled() {
    std::sort(parts_.begin(), parts_.end(), [](const LabelMaskPart& a, const LabelMaskPart& b) {
      return a.label != b.label ? a.label < b.label : is_before(a.part, b.part);
    });
    std::vector<LabelMask> masks;
    for (std::size_t begin = 0; begin < parts_.size();) {
      const std::uint32_t label = parts_[begin].label;
      std::vector<MaskPart> parts;
      for (; begin < parts_.size() && parts_[begin].label == label; ++begin) {
        parts.push_back(std::move(parts_[begin].part));
      }
      masks.push_back({tree_.labels()[label], assemble(tree_.size(), 1, parts)});
    }
    return masks;
  }

  const LabelTree& tree_;
  std::uint64_t max_bytes_;
  std::vector<LabelMaskPart> parts_;
  std::atomic<std::uint64_t> bytes_ = 0;
};

}  // namespace

MaskTree mask_of(const LabelTree& tree, std::span<const std::int64_t> labels) {
  return Union(tree, labels).make();
}

std::vector<LabelMask> masks_of(const LabelTree& tree, std::uint64_t max_bytes) {
  const bool has_background = std::ranges::binary_search(tree.labels(), 0);
  if (tree.labels().size() - (has_background ? 1 : 0) > kMostLabelMasks) {
    throw Error(ErrorKind::limit_exceeded, "there are more than " +
                                               std::to_string(kMostLabelMasks) +
                                               " labels; choose some of them by a range");
  }
  return AllMasks(tree, max_bytes).make();
}

std::vector<LabelMask> masks_of_labels(const FileReader& reader, int level,
                                       std::span<const ValueWindow> windows, Progress& progress,
                                       std::uint64_t max_bytes) {
  const LabelTree tree = labels_of_file(reader, level, windows, progress, max_bytes);
  return masks_of(tree, max_bytes);
}

}  // namespace octavo
