#include "octavo/ops/label/label_build.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/memory_limit.h"
#include "octavo/octree/label_words.h"
#include "octavo/octree/word_steps.h"
#include "octavo/ops/label/label_pieces.h"
#include "octavo/ops/mask/mask_pieces.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr std::uint64_t kCubeWords = 4096;

// Where the voxels of a word stand in its rows [z][y][x], by bit.
constexpr std::array<std::uint8_t, 64> kRowPlaces = [] {
  std::array<std::uint8_t, 64> places{};
  for (std::size_t bit = 0; bit < 64; ++bit) {
    const std::size_t x = (bit >> 1 & 1) + 2 * (bit >> 4 & 1);
    const std::size_t y = (bit & 1) + 2 * (bit >> 3 & 1);
    const std::size_t z = (bit >> 2 & 1) + 2 * (bit >> 5 & 1);
    places[bit] = static_cast<std::uint8_t>((z * 4 + y) * 4 + x);
  }
  return places;
}();

template <class T>
std::uint64_t bits_with(const T* rows, T label) {
  std::uint64_t bits = 0;
  for (std::size_t bit = 0; bit < 64; ++bit) {
    bits |= static_cast<std::uint64_t>(rows[kRowPlaces[bit]] == label) << bit;
  }
  return bits;
}

// Which labels are kept; the others count as 0.
class LabelChoice {
 public:
  explicit LabelChoice(std::span<const ValueWindow> windows) : windows_(windows) {}

  std::int64_t kept(std::int64_t label) const { return is_wanted(label) ? label : 0; }

  bool is_wanted(std::int64_t label) const {
    return std::any_of(windows_.begin(), windows_.end(), [&](const ValueWindow& window) {
      return window.contains(static_cast<double>(label));
    });
  }

 private:
  std::span<const ValueWindow> windows_;
};

// Folds words of voxels.
class WordFolder {
 public:
  WordFolder(const LabelChoice& choice, LabelFold& fold) : choice_(choice), fold_(fold) {}

  void add_uniform(std::int64_t label) { fold_.add_uniform(kept(label)); }

  /// A word of voxels in rows [z][y][x].
  template <class T>
  void add(const T* rows) {
    // All are the first one when each equals the one before.
    if (std::memcmp(rows, rows + 1, 63 * sizeof(T)) == 0) {
      add_uniform(static_cast<std::int64_t>(rows[0]));
      return;
    }
    std::size_t count = 0;
    std::uint64_t zeros = 0;
    for (std::uint64_t left = kFullWord; left != 0;) {
      const T voxel = rows[kRowPlaces[static_cast<std::size_t>(std::countr_zero(left))]];
      const std::uint64_t bits = bits_with(rows, voxel);
      left &= ~bits;
      const std::int64_t label = kept(static_cast<std::int64_t>(voxel));
      if (label == 0) {
        zeros |= bits;
      } else {
        found_[count++] = {label, bits};
      }
    }
    if (zeros != 0) found_[count++] = {0, zeros};
    if (count == 1) {
      fold_.add_uniform(found_[0].label);
    } else {
      fold_.add_mixed(std::span(found_).first(count));
    }
  }

 private:
  std::int64_t kept(std::int64_t label) {
    if (label != last_) {
      last_ = label;
      last_kept_ = choice_.kept(label);
    }
    return last_kept_;
  }

  const LabelChoice& choice_;
  LabelFold& fold_;
  std::array<LabelBits, 64> found_;
  std::int64_t last_ = 0;
  std::int64_t last_kept_ = 0;
};

// Folds a block of at most 64^3 voxels; what it lacks of a cube is 0.
template <class T>
LabelArrays folded(const T* voxels, const BrickView& block, const LabelChoice& choice,
                   LabelFold& fold) {
  WordFolder words(choice, fold);
  std::array<T, 64> rows;
  for (std::uint64_t word = 0; word < kCubeWords; ++word) {
    const Index3 at = deinterleave(word);
    const Size3 size{std::min<std::int64_t>(4, block.size.x - 4 * at.x),
                     std::min<std::int64_t>(4, block.size.y - 4 * at.y),
                     std::min<std::int64_t>(4, block.size.z - 4 * at.z)};
    if (size.x <= 0 || size.y <= 0 || size.z <= 0) {
      words.add_uniform(0);
      continue;
    }
    const bool is_whole = size.x == 4 && size.y == 4 && size.z == 4;
    if (!is_whole) rows.fill(0);
    const T* const first =
        voxels + 4 * (at.z * block.plane_stride + at.y * block.row_stride + at.x);
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        const T* const row = first + z * block.plane_stride + y * block.row_stride;
        T* const to = rows.data() + 16 * z + 4 * y;
        if (is_whole) {
          std::memcpy(to, row, 4 * sizeof(T));
        } else {
          std::copy_n(row, size.x, to);
        }
      }
    }
    words.add(rows.data());
  }
  return fold.finish();
}

LabelArrays folded(const BrickView& block, const LabelChoice& choice, LabelFold& fold) {
  return with_voxel_type(block.type, [&](auto id) -> LabelArrays {
    using T = typename decltype(id)::type;
    if constexpr (std::is_integral_v<T>) {
      return folded(static_cast<const T*>(block.voxels), block, choice, fold);
    } else {
      throw Error(ErrorKind::invalid_argument, "float32 voxels are no labels");
    }
  });
}

// Folds a brick of words; what it lacks of a cube is 0.
LabelArrays folded(const LabelWords& words, const LabelChoice& choice, LabelFold& fold) {
  std::vector<std::int64_t> kept;
  for (const std::int64_t label : words.labels) kept.push_back(choice.kept(label));
  std::array<LabelBits, 65> found;
  for (std::size_t word = 0; word < LabelWords::kCount; ++word) {
    std::size_t count = 0;
    std::uint64_t zeros = kFullWord;
    for (const LabelWordPart& part : words.parts_of(word)) {
      const std::int64_t label = kept[part.label];
      if (label == 0) continue;
      found[count++] = {label, part.bits};
      zeros &= ~part.bits;
    }
    if (zeros != 0) found[count++] = {0, zeros};
    if (count == 1) {
      fold.add_uniform(found[0].label);
    } else {
      fold.add_mixed(std::span(found).first(count));
    }
  }
  return fold.finish();
}

// Folds a block of one label that is not 0.
LabelArrays folded(std::int64_t label, const Size3& size, LabelFold& fold) {
  for (std::uint64_t word = 0; word < kCubeWords; ++word) {
    const Index3 at = deinterleave(word);
    const std::uint64_t bits =
        bits_within({size.x - 4 * at.x, size.y - 4 * at.y, size.z - 4 * at.z});
    if (bits == 0 || bits == kFullWord) {
      fold.add_uniform(bits == 0 ? 0 : label);
    } else {
      std::array<LabelBits, 2> found = {LabelBits{0, ~bits}, LabelBits{label, bits}};
      fold.add_mixed(found);
    }
  }
  return fold.finish();
}

// Folds the cubes of 64^3 of a volume, a layer at a time.
class Layers {
 public:
  explicit Layers(const Size3& size) : size_(size) {
    checked_voxel_count(size);
    for (int axis = 0; axis < 3; ++axis) cubes_[axis] = (size[axis] + kCubeSide - 1) / kCubeSide;
  }

  std::int64_t count() const { return cubes_.z; }
  std::int64_t planes(std::int64_t layer) const {
    return std::min(kCubeSide, size_.z - layer * kCubeSide);
  }

  /// Bytes of all that was folded.
  std::uint64_t bytes() const { return bytes_; }

  /// fold(box, LabelFold&) gives the arrays of a cube, or nothing where all of it is 0.
  template <class Fold>
  void take(std::int64_t layer, Fold fold) {
    std::vector<std::optional<LabelArrays>> found(static_cast<std::size_t>(cubes_.x * cubes_.y));
    const auto cube_at = [&](std::size_t i) {
      const auto at = static_cast<std::int64_t>(i);
      return Index3{at % cubes_.x, at / cubes_.x, layer};
    };
    parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
      const Index3 at = cube_at(i);
      const Index3 lo{at.x * kCubeSide, at.y * kCubeSide, at.z * kCubeSide};
      const Box cube = child_box(lo, 0, kCubeSide);
      found[i] = fold(intersection(cube, box_of(size_)), folds_.local());
    });
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i]) continue;
      parts_.push_back({interleave(cube_at(i)), std::move(*found[i])});
      bytes_ += sizeof parts_.back() + memory_bytes(parts_.back().arrays);
    }
  }

  LabelTree join() {
    std::sort(parts_.begin(), parts_.end(),
              [](const LabelPart& a, const LabelPart& b) { return a.code < b.code; });
    return join_labels(size_, std::move(parts_));
  }

 private:
  Size3 size_;
  Size3 cubes_;  // of 64^3 voxels, per axis
  std::vector<LabelPart> parts_;
  std::uint64_t bytes_ = 0;
  PerThread<LabelFold> folds_;
};

// Takes the bricks of a file.
class FileLabels {
 public:
  FileLabels(const FileReader& reader, int level, std::span<const ValueWindow> windows)
      : reader_(reader), level_(level), choice_(windows) {}

  std::optional<LabelArrays> fold(const Box& box, LabelFold& fold) {
    if (const auto only = only_label(box)) {
      const std::int64_t label = choice_.kept(*only);
      if (label == 0) return std::nullopt;
      return folded(label, box.size(), fold);
    }
    const Size3 side = reader_.levels().brick_side(0);
    if (level_ == 0 && side == Size3{kCubeSide, kCubeSide, kCubeSide}) {
      LabelWords& words = words_.local();
      const Index3 brick{box.lo.x / side.x, box.lo.y / side.y, box.lo.z / side.z};
      reader_.read_words(reader_.brick(0, brick), words);
      return folded(words, choice_, fold);
    }
    const VoxelType type = reader_.description().type;
    const Size3 size = box.size();
    std::vector<std::byte>& voxels = voxels_.local();
    voxels.resize(static_cast<std::size_t>(size.voxel_count() * bytes_per_voxel(type)));
    reader_.read(box, level_, voxels.data());
    return folded({voxels.data(), type, size, size.x, size.x * size.y}, choice_, fold);
  }

 private:
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

  const FileReader& reader_;
  int level_;
  LabelChoice choice_;
  PerThread<std::vector<std::byte>> voxels_;
  PerThread<LabelWords> words_;
};

// What a mask has in a cube.
struct MaskPortion {
  std::int64_t label = 0;
  const MaskTree* mask = nullptr;
  MaskPiece piece;
};

// The cube of 16^3 at `bit`, which is not stored where it is uniform.
MaskCube child_of(const MaskPortion& portion, int bit) {
  const MaskCube& cube = portion.piece.cube;
  if ((cube.mixed >> bit & 1) != 0) return portion.mask->cubes(0)[cube.place_of(bit)];
  return {(cube.full >> bit & 1) != 0 ? kFullWord : 0, 0, 0};
}

std::uint64_t word_of(const MaskTree& mask, const MaskCube& cube, int bit) {
  if ((cube.mixed >> bit & 1) != 0) return mask.words()[cube.place_of(bit)];
  return (cube.full >> bit & 1) != 0 ? kFullWord : 0;
}

// Folds a cube of 64^3 out of all masks that have something in it, by ascending labels.
class MaskFolder {
 public:
  explicit MaskFolder(LabelFold& fold) : fold_(fold) {}

  LabelArrays folded(std::span<const MaskPortion> portions) {
    for (int bit = 0; bit < 64; ++bit) {
      here_.clear();
      for (const MaskPortion& portion : portions) {
        const MaskCube child = child_of(portion, bit);
        if (!child.is_empty()) here_.push_back({portion.label, portion.mask, {0, child}});
      }
      for (int inner = 0; inner < 64; ++inner) add_word(inner);
    }
    return fold_.finish();
  }

 private:
  void add_word(int bit) {
    std::uint64_t rest = kFullWord;
    std::size_t count = 0;
    for (const MaskPortion& portion : here_) {
      const std::uint64_t bits = word_of(*portion.mask, portion.piece.cube, bit);
      if (bits == 0) continue;
      if ((bits & ~rest) != 0) {
        throw Error(ErrorKind::invalid_argument, "a voxel lies in two masks; labels are apart");
      }
      rest &= ~bits;
      if (count > 0 && found_[count - 1].label == portion.label) {
        found_[count - 1].bits |= bits;
      } else {
        found_[count++] = {portion.label, bits};
      }
    }
    if (rest != 0) found_[count++] = {0, rest};
    if (count == 1) {
      fold_.add_uniform(found_[0].label);
    } else {
      fold_.add_mixed(std::span(found_).first(count));
    }
  }

  LabelFold& fold_;
  std::vector<MaskPortion> here_;  // in the cube of 16^3
  std::array<LabelBits, 64> found_;
};

}  // namespace

LabelTree labels_of_file(const FileReader& reader, int level, std::span<const ValueWindow> windows,
                         Progress& progress, std::uint64_t max_bytes) {
  if (level < 0 || level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument, "there is no level " + std::to_string(level));
  }
  if (reader.description().kind != VolumeKind::labels) {
    throw Error(ErrorKind::invalid_argument, "holds grey values, not labels",
                reader.source().name());
  }
  FileLabels labels(reader, level, windows);
  Layers layers(reader.levels().size(level));
  for (std::int64_t layer = 0; layer < layers.count(); ++layer) {
    layers.take(layer, [&](const Box& box, LabelFold& fold) {
      if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
      return labels.fold(box, fold);
    });
    require_memory_within(2 * layers.bytes(), max_bytes, "the labels");
    progress.advance(layers.planes(layer));
  }
  return layers.join();
}

LabelTree make_labels(const BrickView& volume) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const ValueWindow all{-kInfinity, kInfinity};
  const LabelChoice choice({&all, 1});
  Layers layers(volume.size);
  for (std::int64_t layer = 0; layer < layers.count(); ++layer) {
    layers.take(layer, [&](const Box& box, LabelFold& fold) -> std::optional<LabelArrays> {
      BrickView block = volume;
      block.size = box.size();
      block.voxels = static_cast<const std::byte*>(volume.voxels) +
                     (box.lo.z * volume.plane_stride + box.lo.y * volume.row_stride + box.lo.x) *
                         bytes_per_voxel(volume.type);
      return folded(block, choice, fold);
    });
  }
  return layers.join();
}

LabelTree labels_of_masks(const Size3& size, std::span<const LabelMask> masks) {
  checked_voxel_count(size);
  std::vector<MaskPortion> portions;
  for (const LabelMask& mask : masks) {
    if (mask.label == 0) {
      throw Error(ErrorKind::invalid_argument, "0 is the background and no label of a mask");
    }
    if (mask.tree.size() != size) {
      throw Error(ErrorKind::invalid_argument, "a mask has another size than the label map");
    }
    for (const MaskPiece& piece : pieces_at(mask.tree, 1)) {
      portions.push_back({mask.label, &mask.tree, piece});
    }
  }
  const auto is_before = [](const MaskPortion& a, const MaskPortion& b) {
    return a.piece.code != b.piece.code ? a.piece.code < b.piece.code : a.label < b.label;
  };
  std::stable_sort(portions.begin(), portions.end(), is_before);
  std::vector<std::span<const MaskPortion>> cubes;
  for (std::size_t begin = 0; begin < portions.size();) {
    std::size_t end = begin;
    while (end < portions.size() && portions[end].piece.code == portions[begin].piece.code) ++end;
    cubes.push_back(std::span<const MaskPortion>(portions).subspan(begin, end - begin));
    begin = end;
  }
  std::vector<LabelPart> parts(cubes.size());
  PerThread<LabelFold> folds;
  parallel_for(std::size_t{0}, cubes.size(), [&](std::size_t i) {
    parts[i] = {cubes[i].front().piece.code, MaskFolder(folds.local()).folded(cubes[i])};
  });
  return join_labels(size, std::move(parts));
}

}  // namespace octavo
