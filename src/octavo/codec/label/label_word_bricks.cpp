#include "octavo/codec/label/label_word_bricks.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>
#include <numeric>
#include <optional>
#include <span>
#include <utility>

#include "octavo/codec/label/label_octant.h"
#include "octavo/octree/word_steps.h"

namespace octavo {

namespace {

struct Place {
  std::uint8_t x, y, z;
};

// The 64 children of a cube, and the voxels of a word, by bit.
constexpr std::array<Place, 64> kPlaces = [] {
  std::array<Place, 64> places{};
  for (std::size_t bit = 0; bit < 64; ++bit) {
    places[bit] = {static_cast<std::uint8_t>((bit >> 1 & 1) + 2 * (bit >> 4 & 1)),
                   static_cast<std::uint8_t>((bit & 1) + 2 * (bit >> 3 & 1)),
                   static_cast<std::uint8_t>((bit >> 2 & 1) + 2 * (bit >> 5 & 1))};
  }
  return places;
}();

constexpr std::size_t kWordsPerOctant = 8;

// Where a word stands among the words of its brick.
Index3 place_of_word(std::size_t word) {
  const Place& cube = kPlaces[word / 64];
  const Place& own = kPlaces[word % 64];
  return {4 * cube.x + own.x, 4 * cube.y + own.y, 4 * cube.z + own.z};
}

// Calls visit(word, its place) for all words.
template <class Visit>
void visit_words(Visit visit) {
  for (std::size_t word = 0; word < LabelWords::kCount; ++word) visit(word, place_of_word(word));
}

Index3 scaled(const Index3& place, std::int64_t factor) {
  return {factor * place.x, factor * place.y, factor * place.z};
}

constexpr unsigned byte_at(std::uint64_t word, std::size_t octant) {
  return static_cast<unsigned>(word >> 8 * octant & 0xff);
}

// ---- from words to a pyramid

// Levels 1 and 2 of a pyramid over voxels, word by word: votes are counts of bits.
class WordVotes {
 public:
  explicit WordVotes(LabelPyramid& pyramid)
      : octants_(pyramid.levels[1]), words_(pyramid.levels[2]) {}

  void take(const Index3& place, std::span<const LabelWordPart> parts) {
    if (parts.empty()) return;
    const std::ptrdiff_t at = words_.at(place);
    words_.rank[at] = parts.size() == 1 ? parts[0].label : winner_of_octants(place, parts);
    words_.is_uniform[at] = parts.size() == 1;
  }

 private:
  // A level by its arrays.
  struct Samples {
    explicit Samples(LabelPyramid::Level& level)
        : rank(level.rank.data()),
          is_uniform(level.is_uniform.data()),
          row(level.size.x),
          plane(level.size.x * level.size.y),
          steps(child_steps(kHalveAll, row, plane)) {}

    std::ptrdiff_t at(const Index3& p) const { return p.z * plane + p.y * row + p.x; }

    std::uint32_t* rank;
    std::uint8_t* is_uniform;
    std::ptrdiff_t row;
    std::ptrdiff_t plane;
    std::array<std::ptrdiff_t, 8> steps;
  };

  // Fills in the octants of a word of several labels. Returns the label that octants of most voxels
  // have, the smallest of those.
  std::uint32_t winner_of_octants(const Index3& place, std::span<const LabelWordPart> parts) {
    const std::ptrdiff_t octant_at = octants_.at(scaled(place, 2));
    std::array<int, 64> votes;
    const auto votes_end = votes.begin() + static_cast<std::ptrdiff_t>(parts.size());
    std::fill(votes.begin(), votes_end, 0);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      std::size_t winner = 0;
      int most = 0;
      int voxel_count = 0;
      int label_count = 0;
      for (std::size_t i = 0; i < parts.size(); ++i) {
        const int count = std::popcount(byte_at(parts[i].bits, octant));
        voxel_count += count;
        label_count += count != 0;
        if (count <= most) continue;
        most = count;
        winner = i;
      }
      if (most == 0) continue;  // outside the brick
      const std::ptrdiff_t at = octant_at + octants_.steps[octant];
      octants_.rank[at] = parts[winner].label;
      octants_.is_uniform[at] = label_count == 1;
      votes[winner] += voxel_count;
    }
    const auto best = std::max_element(votes.begin(), votes_end);
    return parts[static_cast<std::size_t>(best - votes.begin())].label;
  }

  Samples octants_;
  Samples words_;
};

void make_level(const Size3& size, LabelPyramid::Level& level) {
  const auto count = static_cast<std::size_t>(size.voxel_count());
  level.size = size;
  level.rank.resize(count);
  level.is_uniform.resize(count);
}

// ---- from cells to words

// Collects the voxels of a word by their labels.
class WordParts {
 public:
  void clear() { count_ = 0; }

  void add(std::uint32_t label, std::uint64_t bits) {
    for (std::size_t i = count_; i-- > 0;) {
      if (parts_[i].label == label) {
        parts_[i].bits |= bits;
        return;
      }
    }
    parts_[count_++] = {label, bits};
  }

  void append_to(std::vector<LabelWordPart>& all) {
    const auto end = parts_.begin() + static_cast<std::ptrdiff_t>(count_);
    std::sort(parts_.begin(), end,
              [](const LabelWordPart& a, const LabelWordPart& b) { return a.label < b.label; });
    all.insert(all.end(), parts_.begin(), end);
  }

 private:
  std::size_t count_ = 0;
  std::array<LabelWordPart, 64> parts_;
};

// Reads words off the cells of level 0 and, where octants have cells of their own, of level 1.
class CellReader {
 public:
  CellReader(const LabelGrid& voxels, const LabelGrid* octants,
             const std::vector<std::uint32_t>& label_of_slot)
      : voxels_(voxels), octants_(octants), label_of_slot_(label_of_slot) {
    voxel_steps_ = child_steps(kHalveAll, voxels.row_stride(), voxels.plane_stride());
    if (octants != nullptr) {
      octant_steps_ = child_steps(kHalveAll, octants->row_stride(), octants->plane_stride());
    }
    is_pair_ = label_of_slot.size() == 2 && label_of_slot[0] != label_of_slot[1];
  }

  /// The label of the eight words from `place` on, where they have but one.
  std::optional<std::uint32_t> only_label_of_words(const Index3& place) const {
    if (octants_ == nullptr) return std::nullopt;
    const LabelCell* const first = octants_->at(scaled(place, 2));
    const LabelCell* plane = first;
    std::uint64_t differs = 0;
    for (int z = 0; z < 4; ++z, plane += octants_->plane_stride()) {
      const LabelCell* row = plane;
      for (int y = 0; y < 4; ++y, row += octants_->row_stride()) {
        std::uint64_t four;
        std::memcpy(&four, row, sizeof four);
        differs |= four ^ *first * 0x0001000100010001u;
      }
    }
    const bool is_one = state_of(*first) == kUniform && differs == 0;
    return is_one ? std::optional(label_of_slot_[slot_of(*first)]) : std::nullopt;
  }

  /// Appends the parts of the word at `place`.
  /// inside  the bits of its voxels in the brick, not 0
  void read(const Index3& place, std::uint64_t inside, std::vector<LabelWordPart>& parts) {
    const LabelCell* const octant = octants_ != nullptr ? octants_->at(scaled(place, 2)) : nullptr;
    const LabelCell* const voxel = voxels_.at(scaled(place, 4));
    if (octant != nullptr && is_uniform_word(octant)) {
      parts.push_back({label_of_slot_[slot_of(*octant)], inside});
      return;
    }
    if (is_pair_) {
      append_pair(inside, inside & second_of_pair(octant, voxel, inside), parts);
      return;
    }
    word_.clear();
    for (std::size_t i = 0; i < 8; ++i) {
      const LabelCell cell = octant_cell(octant, i, inside);
      if (state_of(cell) == kUniform) {
        word_.add(label_of_slot_[slot_of(cell)], std::uint64_t{0xff} << 8 * i & inside);
      } else if (state_of(cell) != kOutside) {
        read_octant(voxel + 2 * voxel_steps_[i], 8 * i);
      }
    }
    word_.append_to(parts);
  }

 private:
  bool is_uniform_word(const LabelCell* octant) const {
    if (state_of(*octant) != kUniform) return false;
    const std::uint32_t twice = *octant * 0x10001u;
    std::uint32_t differs = 0;
    for (const int digit : {0, 1, 4, 5}) {  // and the one beside it along x
      std::uint32_t two;
      std::memcpy(&two, octant + octant_steps_[static_cast<std::size_t>(digit)], sizeof two);
      differs |= two ^ twice;
    }
    return differs == 0;
  }

  // Without cells of their own all octants are looked into that have voxels inside: around others
  // the grid ends.
  LabelCell octant_cell(const LabelCell* octant, std::size_t i, std::uint64_t inside) const {
    if (octant != nullptr) return octant[octant_steps_[i]];
    return (inside >> 8 * i & 0xff) != 0 ? LabelCell{kMixed} : LabelCell{kOutside};
  }

  // The bits of slot 1 in a word, where there are two slots.
  std::uint64_t second_of_pair(const LabelCell* octant, const LabelCell* voxel,
                               std::uint64_t inside) const {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < 8; ++i) {
      const LabelCell cell = octant_cell(octant, i, inside);
      if (state_of(cell) == kUniform) {
        bits |= (slot_of(cell) * std::uint64_t{0xff}) << 8 * i;
      } else if (state_of(cell) != kOutside) {
        bits |= second_of_octant(voxel + 2 * voxel_steps_[i]) << 8 * i;
      }
    }
    return bits;
  }

  std::uint64_t second_of_octant(const LabelCell* voxel) const {
    std::uint64_t bits = 0;
    for (const unsigned digit : {0u, 1u, 4u, 5u}) {  // and the voxel beside it along x
      std::uint32_t two;
      std::memcpy(&two, voxel + voxel_steps_[digit], sizeof two);
      bits |= (std::uint64_t{two >> 2 & 1} | std::uint64_t{two >> 18 & 1} << 2) << digit;
    }
    return bits;
  }

  void append_pair(std::uint64_t inside, std::uint64_t second,
                   std::vector<LabelWordPart>& parts) const {
    LabelWordPart lower{label_of_slot_[0], inside & ~second};
    LabelWordPart upper{label_of_slot_[1], second};
    if (upper.label < lower.label) std::swap(lower, upper);
    if (lower.bits != 0) parts.push_back(lower);
    if (upper.bits != 0) parts.push_back(upper);
  }

  void read_octant(const LabelCell* voxel, std::size_t first_bit) {
    for (std::size_t i = 0; i < 8; ++i) {
      const LabelCell cell = voxel[voxel_steps_[i]];
      if (state_of(cell) == kOutside) continue;
      word_.add(label_of_slot_[slot_of(cell)], std::uint64_t{1} << (first_bit + i));
    }
  }

  const LabelGrid& voxels_;
  const LabelGrid* octants_;
  const std::vector<std::uint32_t>& label_of_slot_;
  bool is_pair_ = false;
  std::array<std::ptrdiff_t, 8> voxel_steps_{};
  std::array<std::ptrdiff_t, 8> octant_steps_{};
  WordParts word_;
};

}  // namespace

void build_label_pyramid(const BrickShape& shape, const LabelWords& words,
                         LabelPyramid& pyramid) {
  check_label_shape(shape);
  const auto level_count = static_cast<std::size_t>(shape.level_count);
  pyramid.labels = words.labels;
  pyramid.levels.resize(level_count + 1);
  pyramid.levels[0].size = shape.size[0];
  pyramid.words = nullptr;

  const bool has_word_levels = shape.weights == SampleWeights{} && level_count >= 2 &&
                               shape.halving[0] == kHalveAll && shape.halving[1] == kHalveAll;
  std::size_t made = 0;
  if (has_word_levels) {
    for (std::size_t i = 1; i <= 2; ++i) {
      make_level(halved(pyramid.levels[i - 1].size, kHalveAll), pyramid.levels[i]);
    }
    WordVotes votes(pyramid);
    visit_words([&](std::size_t word, const Index3& place) {
      votes.take(place, words.parts_of(word));
    });
    pyramid.words = &words;
    made = 2;
  } else {
    complete_voxels(words, pyramid);
  }
  for (; made < level_count; ++made) {
    condense_labels(shape, static_cast<int>(made), pyramid.levels[made], pyramid.levels[made + 1]);
  }
}

void complete_voxels(const LabelWords& words, LabelPyramid& pyramid) {
  LabelPyramid::Level& voxels = pyramid.levels[0];
  make_level(voxels.size, voxels);
  std::fill(voxels.is_uniform.begin(), voxels.is_uniform.end(), std::uint8_t{1});
  visit_words([&](std::size_t word, const Index3& place) {
    const Index3 corner = scaled(place, 4);
    for (const LabelWordPart& part : words.parts_of(word)) {
      for (std::uint64_t left = part.bits; left != 0; left &= left - 1) {
        const Place& at = kPlaces[static_cast<std::size_t>(std::countr_zero(left))];
        voxels.rank[dense_offset(voxels.size,
                                 {corner.x + at.x, corner.y + at.y, corner.z + at.z})] = part.label;
      }
    }
  });
  pyramid.words = nullptr;
}

void words_of_cells(const BrickShape& shape, const LabelWork& work, LabelWords& words) {
  // Slots by the order of their labels; a damaged brick may have a label twice.
  std::vector<std::int64_t> labels = work.labels;
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  std::vector<std::uint32_t> label_of_slot;
  for (const std::int64_t label : work.labels) {
    const auto at = std::lower_bound(labels.begin(), labels.end(), label) - labels.begin();
    label_of_slot.push_back(static_cast<std::uint32_t>(at));
  }

  const bool has_octants = shape.halving[0] == kHalveAll;
  CellReader cells(work.grid, has_octants ? &work.parents : nullptr, label_of_slot);
  const Size3& size = shape.size[0];
  const bool is_whole = size == Size3{64, 64, 64};
  words.parts.clear();
  const auto read = [&](std::size_t word) {
    const Index3 place = place_of_word(word);
    words.first[word] = static_cast<std::uint32_t>(words.parts.size());
    const std::uint64_t inside =
        is_whole ? ~std::uint64_t{0}
                 : bits_within({size.x - 4 * place.x, size.y - 4 * place.y, size.z - 4 * place.z});
    if (inside != 0) cells.read(place, inside, words.parts);
  };
  for (std::size_t word = 0; word < LabelWords::kCount; word += kWordsPerOctant) {
    const auto only = is_whole ? cells.only_label_of_words(place_of_word(word)) : std::nullopt;
    if (!only) {
      for (std::size_t i = 0; i < kWordsPerOctant; ++i) read(word + i);
      continue;
    }
    std::iota(words.first.begin() + static_cast<std::ptrdiff_t>(word),
              words.first.begin() + static_cast<std::ptrdiff_t>(word + kWordsPerOctant),
              static_cast<std::uint32_t>(words.parts.size()));
    words.parts.insert(words.parts.end(), kWordsPerOctant, {*only, ~std::uint64_t{0}});
  }
  words.first.back() = static_cast<std::uint32_t>(words.parts.size());
  choose_labels(labels, words);
}

void words_of_voxels(const Size3& size, const std::vector<std::int64_t>& voxels,
                     LabelWords& words) {
  std::vector<std::int64_t> labels = voxels;
  std::sort(labels.begin(), labels.end());
  labels.erase(std::unique(labels.begin(), labels.end()), labels.end());
  WordParts parts;
  words.parts.clear();
  visit_words([&](std::size_t word, const Index3& place) {
    words.first[word] = static_cast<std::uint32_t>(words.parts.size());
    const Index3 corner = scaled(place, 4);
    parts.clear();
    for (std::size_t bit = 0; bit < 64; ++bit) {
      const Place& at = kPlaces[bit];
      const Index3 voxel{corner.x + at.x, corner.y + at.y, corner.z + at.z};
      if (!box_of(size).contains(voxel)) continue;
      const std::int64_t label = voxels[dense_offset(size, voxel)];
      const auto rank = std::lower_bound(labels.begin(), labels.end(), label) - labels.begin();
      parts.add(static_cast<std::uint32_t>(rank), std::uint64_t{1} << bit);
    }
    parts.append_to(words.parts);
  });
  words.first.back() = static_cast<std::uint32_t>(words.parts.size());
  words.labels = std::move(labels);
}

}  // namespace octavo
