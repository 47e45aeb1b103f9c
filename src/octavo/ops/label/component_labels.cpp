#include "octavo/ops/label/component_labels.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/memory_limit.h"
#include "octavo/octree/tree_child.h"
#include "octavo/ops/label/label_pieces.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

constexpr int kCellWords = 4096;

// A cube of 64^3 voxels with something of a component: stored, or all of one.
struct Cell {
  std::uint64_t code = 0;
  bool is_stored = false;
  std::uint64_t place = 0;  // where it is stored, or its label
};

constexpr const char* kMap = "the label map of components";

// Calls visit(bit) for the set bits, ascending.
template <class Visit>
void for_each_bit(std::uint64_t bits, Visit visit) {
  for (; bits != 0; bits &= bits - 1) visit(std::countr_zero(bits));
}

// The cells of a cube, those of components that are not kept left out.
class CellCollector {
 public:
  CellCollector(const Components& found, std::size_t kept, std::uint64_t max_bytes)
      : found_(found), kept_(kept), max_bytes_(max_bytes) {}

  std::vector<Cell> collect() {
    collect(found_.mask().rank_count() - 1, 0, 0);
    std::sort(cells_.begin(), cells_.end(),
              [](const Cell& a, const Cell& b) { return a.code < b.code; });
    return std::move(cells_);
  }

 private:
  void collect(int rank, std::uint64_t place, std::uint64_t code) {
    if (rank == kCellRank) {
      require_room(1);
      cells_.push_back({code, true, place});
      return;
    }
    // A full child holds a whole number of cells.
    const int shift = 6 * (rank - 1 - kCellRank);
    found_.visit_parts(rank, place, [&](std::uint32_t label, std::uint64_t bits) {
      if (label > kept_) return;
      require_room(static_cast<std::uint64_t>(std::popcount(bits)) << shift);
      for_each_bit(bits, [&](int bit) {
        const std::uint64_t first = (code << 6 | static_cast<std::uint64_t>(bit)) << shift;
        for (std::uint64_t i = 0; i < std::uint64_t{1} << shift; ++i) {
          cells_.push_back({first + i, false, label});
        }
      });
    });
    const MaskCube& cube = found_.mask().cubes(rank)[place];
    for_each_bit(cube.mixed, [&](int bit) {
      collect(rank - 1, cube.place_of(bit), code << 6 | static_cast<std::uint64_t>(bit));
    });
  }

  // Before `more` cells are added: what they take, and their parts twice.
  void require_room(std::uint64_t more) const {
    constexpr std::uint64_t kBytesPerCell = sizeof(Cell) + 2 * sizeof(LabelPart);
    const std::uint64_t most = std::numeric_limits<std::uint64_t>::max() / kBytesPerCell;
    const std::uint64_t count = std::min(most, cells_.size() + more);
    require_memory_within(count * kBytesPerCell, max_bytes_, kMap);
  }

  const Components& found_;
  std::size_t kept_;
  std::uint64_t max_bytes_;
  std::vector<Cell> cells_;
};

// Folds one cell after the other.
class CellFolder {
 public:
  CellFolder(const Components& found, std::size_t kept, LabelFold& fold)
      : found_(found), kept_(kept), fold_(fold) {}

  LabelArrays folded(const Cell& cell) {
    if (!cell.is_stored) {
      add_uniform(static_cast<std::int64_t>(cell.place), kCellWords);
      return fold_.finish();
    }
    const auto labels = labels_of_children(kCellRank, cell.place);
    const MaskCube& cube = found_.mask().cubes(kCellRank)[cell.place];
    for (int bit = 0; bit < 64; ++bit) {
      if ((cube.mixed >> bit & 1) != 0) {
        add_words(cube.place_of(bit));
      } else {
        add_uniform(labels[static_cast<std::size_t>(bit)], 64);
      }
    }
    return fold_.finish();
  }

 private:
  void add_uniform(std::int64_t label, int count) {
    for (int i = 0; i < count; ++i) fold_.add_uniform(label);
  }

  std::int64_t kept_label(std::uint32_t label) const { return label > kept_ ? 0 : label; }

  // The labels of the full children of a cube; 0 for all others.
  std::array<std::int64_t, 64> labels_of_children(int rank, std::uint64_t place) const {
    std::array<std::int64_t, 64> labels{};
    found_.visit_parts(rank, place, [&](std::uint32_t label, std::uint64_t bits) {
      for_each_bit(bits, [&](int bit) {
        labels[static_cast<std::size_t>(bit)] = kept_label(label);
      });
    });
    return labels;
  }

  // The words of the cube of 16^3 at `place`.
  void add_words(std::uint64_t place) {
    const auto labels = labels_of_children(0, place);
    const MaskCube& cube = found_.mask().cubes(0)[place];
    for (int bit = 0; bit < 64; ++bit) {
      if ((cube.mixed >> bit & 1) != 0) {
        add_word(cube.place_of(bit));
      } else {
        fold_.add_uniform(labels[static_cast<std::size_t>(bit)]);
      }
    }
  }

  void add_word(std::uint64_t place) {
    std::size_t count = 0;
    std::uint64_t rest = kFullWord;
    found_.visit_parts(-1, place, [&](std::uint32_t part_label, std::uint64_t bits) {
      const std::int64_t label = kept_label(part_label);
      if (label == 0) return;
      rest &= ~bits;
      for (std::size_t i = 0; i < count; ++i) {
        if (labels_[i].label == label) {
          labels_[i].bits |= bits;
          return;
        }
      }
      labels_[count++] = {label, bits};
    });
    if (rest != 0) labels_[count++] = {0, rest};
    if (count == 1) {
      fold_.add_uniform(labels_[0].label);
    } else {
      fold_.add_mixed(std::span(labels_).first(count));
    }
  }

  const Components& found_;
  std::size_t kept_;
  LabelFold& fold_;
  std::array<LabelBits, 64> labels_;
};

}  // namespace

LabelTree labels_of_components(const Components& found, std::size_t kept,
                               std::uint64_t max_bytes, const Progress* watcher) {
  const auto is_stopped = [watcher] { return watcher != nullptr && watcher->is_cancelled(); };
  const std::vector<Cell> cells = CellCollector(found, kept, max_bytes).collect();
  std::vector<LabelPart> parts(cells.size());
  PerThread<LabelFold> folds;
  // With the map that they are joined to, twice.
  std::atomic<std::uint64_t> bytes = cells.size() * sizeof(LabelPart);
  parallel_for(std::size_t{0}, cells.size(), [&](std::size_t i) {
    if (is_stopped()) return;
    parts[i] = {cells[i].code, CellFolder(found, kept, folds.local()).folded(cells[i])};
    const std::uint64_t own = memory_bytes(parts[i].arrays);
    require_memory_within(2 * (bytes.fetch_add(own) + own), max_bytes, kMap);
  });
  if (is_stopped()) throw Error(ErrorKind::cancelled, "stopped while labeling components");
  return join_labels(found.mask().size(), std::move(parts));
}

}  // namespace octavo
