#include "octavo/ops/label_masks.h"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/ops/mask_pieces.h"

namespace octavo {

namespace {

constexpr std::int64_t kCubeSide = 64;
constexpr std::size_t kCubeVoxels = 64 * 64 * 64;
constexpr std::uint32_t kCubeWords = 4096;

/// The voxels of one label in one word of a cube.
struct LabelWord {
  std::int64_t label = 0;
  std::uint32_t word = 0;
  std::uint64_t bits = 0;
};

/// What one label has in one cube.
struct LabelPart {
  std::int64_t label = 0;
  MaskPart part;
};

// Where the voxels of a word lie in the rows of a cube, by bit.
std::array<std::size_t, 64> places_in_word() {
  std::array<std::size_t, 64> places{};
  for (std::size_t bit = 0; bit < 64; ++bit) {
    const Index3 at = deinterleave(bit);
    places[bit] = static_cast<std::size_t>((at.z * kCubeSide + at.y) * kCubeSide + at.x);
  }
  return places;
}

/// The labels of a cube of 64^3 voxels; 0 beyond the volume.
class CubeLabels {
 public:
  void clear() { labels_.assign(kCubeVoxels, 0); }

  /// Takes voxels [z][y][x] of a box at the cube's lowest corner.
  void take(const std::byte* voxels, VoxelType type, const Size3& size) {
    clear();
    with_voxel_type(type, [&](auto id) {
      using T = typename decltype(id)::type;
      for (std::int64_t z = 0; z < size.z; ++z) {
        for (std::int64_t y = 0; y < size.y; ++y) {
          const std::byte* from =
              voxels + static_cast<std::size_t>((z * size.y + y) * size.x) * sizeof(T);
          std::int64_t* const to = labels_.data() + (z * kCubeSide + y) * kCubeSide;
          for (std::int64_t x = 0; x < size.x; ++x, from += sizeof(T)) {
            T value;
            std::memcpy(&value, from, sizeof value);
            to[x] = static_cast<std::int64_t>(value);
          }
        }
      }
    });
  }

  void fill(std::int64_t label, const Size3& size) {
    clear();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        std::fill_n(labels_.data() + (z * kCubeSide + y) * kCubeSide, size.x, label);
      }
    }
  }

  /// The words of all labels but 0, by label and then in o-code order.
  const std::vector<LabelWord>& words() {
    static const std::array<std::size_t, 64> kPlaces = places_in_word();
    words_.clear();
    for (std::uint32_t word = 0; word < kCubeWords; ++word) {
      const Index3 at = deinterleave(word);
      const std::int64_t* const first =
          labels_.data() + ((at.z * kCubeSide + at.y) * kCubeSide + at.x) * 4;
      std::uint64_t left = kFullWord;
      while (left != 0) {
        const std::int64_t label = first[kPlaces[static_cast<std::size_t>(std::countr_zero(left))]];
        std::uint64_t bits = 0;
        for (std::uint64_t look = left; look != 0; look &= look - 1) {
          const auto bit = static_cast<std::size_t>(std::countr_zero(look));
          if (first[kPlaces[bit]] == label) bits |= std::uint64_t{1} << bit;
        }
        if (label != 0) words_.push_back({label, word, bits});
        left &= ~bits;
      }
    }
    std::stable_sort(words_.begin(), words_.end(),
                     [](const LabelWord& a, const LabelWord& b) { return a.label < b.label; });
    return words_;
  }

 private:
  std::vector<std::int64_t> labels_;
  std::vector<LabelWord> words_;
};

/// The sub-tree of one label, from its words in order.
MaskPart folded(std::span<const LabelWord> words, std::uint64_t code) {
  MaskPart part;
  part.below = arrays_below(1);
  MaskCube cube;
  for (std::size_t i = 0; i < words.size();) {
    const std::uint32_t bit = words[i].word >> 6;
    WordCube child;
    for (; i < words.size() && words[i].word >> 6 == bit; ++i) {
      child.add(static_cast<int>(words[i].word & 63), words[i].bits);
    }
    add_child(child.finish(part.below.words), static_cast<int>(bit), cube, part.below.cubes[0]);
  }
  part.below.words.shrink_to_fit();
  part.pieces.push_back({code, cube});
  return part;
}

class LabelMasks {
 public:
  LabelMasks(const FileReader& reader, int level, std::span<const ValueWindow> windows,
             Progress& progress, std::uint64_t max_bytes)
      : reader_(reader),
        level_(level),
        windows_(windows),
        progress_(progress),
        max_bytes_(max_bytes),
        size_(reader.levels().size(level)) {}

  std::vector<LabelMask> make() {
    for (int axis = 0; axis < 3; ++axis) cubes_[axis] = (size_[axis] + kCubeSide - 1) / kCubeSide;
    for (std::int64_t layer = 0; layer < cubes_.z; ++layer) {
      take_layer(layer);
      progress_.advance(std::min(kCubeSide, size_.z - layer * kCubeSide));
    }
    return assembled();
  }

 private:
  void take_layer(std::int64_t layer) {
    std::vector<std::vector<LabelPart>> found(static_cast<std::size_t>(cubes_.x * cubes_.y));
    tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
      if (progress_.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      const auto at = static_cast<std::int64_t>(i);
      found[i] = parts_of({at % cubes_.x, at / cubes_.x, layer});
    });
    for (std::vector<LabelPart>& parts : found) {
      for (LabelPart& part : parts) {
        bytes_ += 2 * memory_bytes(part.part);
        parts_.push_back(std::move(part));
      }
    }
    require_memory_within(bytes_, max_bytes_, "the masks",
                          "raise the limit, or take a coarser level");
  }

  std::vector<LabelPart> parts_of(const Index3& cube) {
    const Index3 lo{cube.x * kCubeSide, cube.y * kCubeSide, cube.z * kCubeSide};
    const Box box =
        intersection(box_of(size_), {lo, {lo.x + kCubeSide, lo.y + kCubeSide, lo.z + kCubeSide}});
    const std::optional<std::int64_t> only = only_label(box);
    if (only == 0) return {};
    CubeLabels& labels = labels_.local();
    if (only) {
      labels.fill(*only, box.size());
    } else {
      const VoxelType type = reader_.description().type;
      std::vector<std::byte> voxels(
          static_cast<std::size_t>(box.size().voxel_count() * bytes_per_voxel(type)));
      reader_.read(box, level_, voxels.data());
      labels.take(voxels.data(), type, box.size());
    }
    std::vector<LabelPart> parts;
    const std::span<const LabelWord> words = labels.words();
    for (std::size_t begin = 0; begin < words.size();) {
      std::size_t end = begin;
      while (end < words.size() && words[end].label == words[begin].label) ++end;
      if (is_wanted(words[begin].label)) {
        parts.push_back(
            {words[begin].label, folded(words.subspan(begin, end - begin), interleave(cube))});
      }
      begin = end;
    }
    return parts;
  }

  /// The label of all bricks of a box of level 0, where they have but one.
  std::optional<std::int64_t> only_label(const Box& box) const {
    if (level_ != 0) return std::nullopt;
    const Size3 side = reader_.levels().brick_side(0);
    std::optional<std::int64_t> only;
    visit_cells(box, side, [&](const Index3& brick) {
      const ValueRange range = reader_.brick(0, brick).range;
      const bool is_same = range.min == range.max && range.min == only.value_or(range.min);
      only = is_same ? std::optional(range.min) : std::nullopt;
      return is_same;
    });
    return only;
  }

  bool is_wanted(std::int64_t label) const {
    return std::any_of(windows_.begin(), windows_.end(), [&](const ValueWindow& window) {
      return window.contains(static_cast<double>(label));
    });
  }

  std::vector<LabelMask> assembled() {
    std::sort(parts_.begin(), parts_.end(), [](const LabelPart& a, const LabelPart& b) {
      if (a.label != b.label) return a.label < b.label;
      return a.part.pieces.front().code < b.part.pieces.front().code;
    });
    std::vector<LabelMask> masks;
    for (std::size_t begin = 0; begin < parts_.size();) {
      if (masks.size() == kMostLabelMasks) {
        throw Error(ErrorKind::limit_exceeded, "there are more than " +
                                                   std::to_string(kMostLabelMasks) +
                                                   " labels; choose some of them by a range");
      }
      const std::int64_t label = parts_[begin].label;
      std::vector<MaskPart> parts;
      for (; begin < parts_.size() && parts_[begin].label == label; ++begin) {
        parts.push_back(std::move(parts_[begin].part));
      }
      masks.push_back({label, assemble(size_, 1, parts)});
    }
    return masks;
  }

  const FileReader& reader_;
  int level_;
  std::span<const ValueWindow> windows_;
  Progress& progress_;
  std::uint64_t max_bytes_;
  Size3 size_;
  Size3 cubes_;  // of 64^3 samples, per axis
  std::vector<LabelPart> parts_;
  std::uint64_t bytes_ = 0;
  tbb::enumerable_thread_specific<CubeLabels> labels_;
};

}  // namespace

std::vector<LabelMask> masks_of_labels(const FileReader& reader, int level,
                                       std::span<const ValueWindow> windows, Progress& progress,
                                       std::uint64_t max_bytes) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  if (reader.description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "the volume holds grey values, not labels");
  }
  return LabelMasks(reader, level, windows, progress, max_bytes).make();
}

}  // namespace octavo
