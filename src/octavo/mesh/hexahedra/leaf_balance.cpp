#include "octavo/mesh/hexahedra/leaf_balance.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "octavo/mesh/cancellation.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

constexpr int kBalanceBlockLevel = 4;
constexpr std::uint32_t kNoBlock = ~std::uint32_t{0};

/// Cells of a level in a block, 1 to 3, along an axis.
constexpr int cells_along(int level) { return 1 << (kBalanceBlockLevel - level); }

/// Where the rows of a level begin: a byte for each row of cells along x, [z][y].
constexpr std::size_t first_row(int level) { return level == 1 ? 0 : level == 2 ? 64 : 80; }

struct BalanceBlock {
  std::uint64_t code = 0;  ///< of its cube at kBalanceBlockLevel
  bool is_split = false;   ///< the block itself
  std::array<std::uint8_t, 84> split{};
  std::array<std::uint8_t, 84> full{};   ///< in a leaf of this level or a higher one
  std::array<std::uint64_t, 64> voxels{};  ///< leaves of level 0, in o-code order
  std::array<std::uint32_t, 27> near{};  ///< the blocks around, [z][y][x]; itself in the middle

  std::uint8_t& row(std::array<std::uint8_t, 84>& rows, int level, int y, int z) {
    return rows[first_row(level) + static_cast<std::size_t>(z * cells_along(level) + y)];
  }
};

/// The place of a cell by its code in a block: its row is z * count + y, its bit x.
struct CellPlace {
  std::uint8_t x = 0;
  std::uint8_t y = 0;
  std::uint8_t z = 0;
};

constexpr std::array<CellPlace, 512> kCellPlaces = [] {
  std::array<CellPlace, 512> places{};
  for (unsigned code = 0; code < 512; ++code) {
    for (unsigned bit = 0; bit < 3; ++bit) {
      places[code].y = static_cast<std::uint8_t>(places[code].y | (code >> 3 * bit & 1) << bit);
      places[code].x =
          static_cast<std::uint8_t>(places[code].x | (code >> (3 * bit + 1) & 1) << bit);
      places[code].z =
          static_cast<std::uint8_t>(places[code].z | (code >> (3 * bit + 2) & 1) << bit);
    }
  }
  return places;
}();

/// Bit pairs of a row joined: bit i is set where bit 2i or 2i + 1 is.
std::uint8_t halved_row(std::uint32_t row) {
  row = (row | row >> 1) & 0x55u;
  row = (row | row >> 1) & 0x33u;
  return static_cast<std::uint8_t>((row | row >> 2) & 0x0fu);
}

/// Each of four bits twice.
constexpr std::uint32_t doubled_row(std::uint32_t row) {
  row = (row | row << 2) & 0x33u;
  row = (row | row << 1) & 0x55u;
  return row | row << 1;
}

}  // namespace

class LeafBalance::Blocks {
 public:
  void add(const OCode& leaf) {
    if (leaf.level >= kBalanceBlockLevel) {
      const auto level = static_cast<std::size_t>(leaf.level);
      if (large_.size() <= level) large_.resize(level + 1);
      large_[level].insert(leaf.code);
      large_leaves_.push_back(leaf);
      return;
    }
    const int bits = 3 * (kBalanceBlockLevel - leaf.level);
    BalanceBlock& block = block_of(leaf.code >> bits);
    block.is_split = true;
    const std::uint64_t local = leaf.code & ((std::uint64_t{1} << bits) - 1);
    if (leaf.level == 0) {
      block.voxels[local >> 6] |= std::uint64_t{1} << (local & 63);
      return;
    }
    fill(block, leaf.level, kCellPlaces[local]);
  }

  std::uint64_t memory_bytes() const noexcept {
    // A block, its entry in the table, and as much again for blocks beside those that are split.
    return 2 * blocks_.size() * (sizeof(BalanceBlock) + 32) + 64 * large_leaves_.size();
  }

  std::vector<OCode> finish(const Progress& watcher) {
    find_split(watcher);
    add_full_neighbors();
    find_neighbors(watcher);
    balance_blocks(watcher);
    balance_large();
    stop_if_cancelled(watcher);
    return leaves();
  }

 private:
  /// Calls work(i) for each block, on all threads.
  template <class Work>
  void for_each_block(const Progress& watcher, Work&& work) {
    constexpr std::size_t kBlocksOfPart = 256;
    parallel_parts(std::size_t{0}, blocks_.size(), kBlocksOfPart,
                   [&](std::size_t begin, std::size_t end) {
                     stop_if_cancelled(watcher);
                     for (std::size_t i = begin; i < end; ++i) work(i);
                   });
  }

  BalanceBlock& block_of(std::uint64_t code) {
    if (last_ < blocks_.size() && blocks_[last_].code == code) return blocks_[last_];
    const auto [place, is_new] = places_.try_emplace(code, blocks_.size());
    if (is_new) {
      // Room that is not used yet takes no memory; to grow by less takes time.
      constexpr std::size_t kBlockGrowth = 4;
      if (blocks_.size() == blocks_.capacity()) {
        blocks_.reserve(std::max<std::size_t>(kBlockGrowth * blocks_.capacity(), 256));
      }
      blocks_.emplace_back().code = code;
    }
    last_ = place->second;
    return blocks_[last_];
  }

  /// Marks a leaf full at its level and at those below.
  static void fill(BalanceBlock& block, int level, const CellPlace& cell) {
    for (int side = 1; level >= 1; --level, side *= 2) {
      const auto bits = static_cast<std::uint8_t>(((1 << side) - 1) << side * cell.x);
      for (int z = 0; z < side; ++z) {
        for (int y = 0; y < side; ++y) {
          block.row(block.full, level, side * cell.y + y, side * cell.z + z) |= bits;
        }
      }
    }
  }

  /// The cells in which smaller leaves lie.
  void find_split(const Progress& watcher) {
    for_each_block(watcher, [this](std::size_t i) {
      BalanceBlock& block = blocks_[i];
      for (std::uint64_t word = 0; word < 64; ++word) {
        const std::uint64_t voxels = block.voxels[word];
        if (voxels == 0) continue;
        for (std::uint64_t octant = 0; octant < 8; ++octant) {
          if ((voxels >> 8 * octant & 0xff) == 0) continue;
          const CellPlace& cell = kCellPlaces[word << 3 | octant];
          block.row(block.split, 1, cell.y, cell.z) |= static_cast<std::uint8_t>(1 << cell.x);
        }
      }
      for (int level = 1; level < 3; ++level) {
        const int count = cells_along(level + 1);
        for (int z = 0; z < count; ++z) {
          for (int y = 0; y < count; ++y) {
            std::uint32_t below = 0;
            for (int k = 0; k < 4; ++k) {
              const int row_y = 2 * y + (k & 1);
              const int row_z = 2 * z + (k >> 1);
              below |= static_cast<std::uint32_t>(block.row(block.split, level, row_y, row_z) |
                                                  block.row(block.full, level, row_y, row_z));
            }
            block.row(block.split, level + 1, y, z) = static_cast<std::uint8_t>(
                halved_row(below) & ~block.row(block.full, level + 1, y, z));
          }
        }
      }
    });
  }

  bool is_in_large_leaf(int level, std::uint64_t code) const {
    for (std::size_t k = static_cast<std::size_t>(level); k < large_.size(); ++k) {
      if (large_[k].contains(code >> 3 * (k - static_cast<std::size_t>(level)))) return true;
    }
    return false;
  }

  /// Calls visit(place in `near`, code) for the 26 around a block that lie in the universe.
  template <class Visit>
  static void visit_around(std::uint64_t code, Visit&& visit) {
    const Index3 at = deinterleave(code);
    for (int place = 0; place < 27; ++place) {
      const Index3 other = {at.x + place % 3 - 1, at.y + place / 3 % 3 - 1, at.z + place / 9 - 1};
      if (place == 13 || other.x < 0 || other.y < 0 || other.z < 0) continue;
      visit(static_cast<std::size_t>(place), interleave(other));
    }
  }

  /// Full blocks beside those that are split may have to be split themselves.
  void add_full_neighbors() {
    if (large_leaves_.empty()) return;
    const std::size_t count = blocks_.size();
    for (std::size_t i = 0; i < count; ++i) {
      visit_around(blocks_[i].code, [&](std::size_t, std::uint64_t code) {
        if (places_.contains(code) || !is_in_large_leaf(kBalanceBlockLevel, code)) return;
        BalanceBlock& block = block_of(code);
        block.full.fill(0xff);
      });
    }
  }

  void find_neighbors(const Progress& watcher) {
    for_each_block(watcher, [this](std::size_t i) {
      BalanceBlock& block = blocks_[i];
      block.near.fill(kNoBlock);
      block.near[13] = static_cast<std::uint32_t>(i);
      visit_around(block.code, [&](std::size_t place, std::uint64_t code) {
        const auto found = places_.find(code);
        if (found != places_.end()) block.near[place] = static_cast<std::uint32_t>(found->second);
      });
    });
  }

  /// Whether each cell of `level` + 1 holds, or touches with a cell of `level` in it, a split cell
  /// of `level`: rows [z][y].
  std::array<std::uint8_t, 16> near_split(const BalanceBlock& block, int level) const {
    const int count = cells_along(level);
    const std::size_t first = first_row(level);
    // Rows with those of the blocks around: bit 0 is the last cell of the block before.
    std::array<std::array<std::uint32_t, 10>, 10> rows{};
    for (int z = -1; z <= count; ++z) {
      const int near_z = z < 0 ? 0 : z == count ? 2 : 1;
      for (int y = -1; y <= count; ++y) {
        const int near_y = y < 0 ? 0 : y == count ? 2 : 1;
        const auto at = first + static_cast<std::size_t>((z & (count - 1)) * count +
                                                         (y & (count - 1)));
        const auto row_of = [&](int near_x) -> std::uint32_t {
          const auto place = static_cast<std::size_t>(9 * near_z + 3 * near_y + near_x);
          const std::uint32_t other = block.near[place];
          return other == kNoBlock ? 0 : blocks_[other].split[at];
        };
        std::uint32_t row = row_of(1) << 1;
        row |= row_of(0) >> (count - 1) & 1;
        row |= (row_of(2) & 1) << (count + 1);
        rows[static_cast<std::size_t>(z + 1)][static_cast<std::size_t>(y + 1)] = row;
      }
    }
    std::array<std::uint8_t, 16> result{};
    const int coarse = count / 2;
    for (int z = 0; z < coarse; ++z) {
      for (int y = 0; y < coarse; ++y) {
        std::uint32_t all = 0;
        for (std::size_t k = 0; k < 16; ++k) {
          all |= rows[static_cast<std::size_t>(2 * z) + k / 4]
                     [static_cast<std::size_t>(2 * y) + k % 4];
        }
        all = (all | all >> 1 | all << 1) >> 1;
        result[static_cast<std::size_t>(z * coarse + y)] = halved_row(all);
      }
    }
    return result;
  }

  void balance_blocks(const Progress& watcher) {
    for (int level = 1; level < kBalanceBlockLevel; ++level) {
      for_each_block(watcher, [this, level](std::size_t i) {
        BalanceBlock& block = blocks_[i];
        const auto wanted = near_split(block, level);
        if (level == kBalanceBlockLevel - 1) {
          block.is_split = block.is_split || wanted[0] != 0;
          return;
        }
        const int count = cells_along(level + 1);
        for (int row = 0; row < count * count; ++row) {
          const std::size_t at = first_row(level + 1) + static_cast<std::size_t>(row);
          block.split[at] |= static_cast<std::uint8_t>(wanted[static_cast<std::size_t>(row)] &
                                                       block.full[at]);
        }
      });
    }
  }

  /// The cells of blocks and above that are split, level by level.
  void balance_large() {
    split_.resize(std::max(large_.size(), std::size_t{kBalanceBlockLevel} + 1));
    for (const BalanceBlock& block : blocks_) {
      if (block.is_split) split_[kBalanceBlockLevel].insert(block.code);
    }
    for (std::size_t level = kBalanceBlockLevel; level + 1 < large_.size(); ++level) {
      auto& above = split_[level + 1];
      for (const std::uint64_t code : split_[level]) {
        above.insert(code >> 3);
        visit_around(code, [&](std::size_t, std::uint64_t beside) {
          const std::uint64_t parent = beside >> 3;
          if (above.contains(parent)) return;
          if (is_in_large_leaf(static_cast<int>(level) + 1, parent)) above.insert(parent);
        });
      }
    }
  }

  bool is_split(int level, std::uint64_t code) const {
    return split_[static_cast<std::size_t>(level)].contains(code);
  }

  /// What stands in the order of first voxels: a leaf, or a block that is split.
  struct LeafPart {
    OCode cube;
    const BalanceBlock* block = nullptr;  ///< nullptr: a leaf
  };

  std::vector<OCode> leaves() const {
    const std::vector<LeafPart> parts = leaf_parts();
    std::vector<std::size_t> begins(parts.size() + 1);
    parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
      begins[i + 1] = parts[i].block == nullptr ? 1 : leaf_count(*parts[i].block);
    });
    for (std::size_t i = 0; i < parts.size(); ++i) begins[i + 1] += begins[i];
    std::vector<OCode> all(begins.back());
    parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
      OCode* const out = all.data() + begins[i];
      if (parts[i].block == nullptr) *out = parts[i].cube;
      else put_leaves(*parts[i].block, out);
    });
    return all;
  }

  std::vector<LeafPart> leaf_parts() const {
    // Leaves that are blocks or larger, and blocks that are split but lie in no such leaf.
    std::vector<OCode> cubes = large_leaves_;
    for (const BalanceBlock& block : blocks_) {
      if (block.is_split && !is_in_large_leaf(kBalanceBlockLevel, block.code)) {
        cubes.push_back({kBalanceBlockLevel, block.code});
      }
    }
    std::sort(cubes.begin(), cubes.end(), [](const OCode& a, const OCode& b) {
      return a.code << 3 * a.level < b.code << 3 * b.level;
    });
    std::vector<LeafPart> parts;
    parts.reserve(cubes.size());
    for (const OCode& cube : cubes) add_parts(cube, parts);
    return parts;
  }

  void add_parts(const OCode& cube, std::vector<LeafPart>& parts) const {
    if (!is_split(cube.level, cube.code)) parts.push_back({cube});
    else if (cube.level == kBalanceBlockLevel) {
      parts.push_back({cube, &blocks_[places_.at(cube.code)]});
    } else {
      for (const OCode& child : children_of(cube)) add_parts(child, parts);
    }
  }

  /// The leaves in a block that is split: voxels, and cells of a level that lie in a split cell of
  /// the next.
  static std::size_t leaf_count(const BalanceBlock& block) {
    int count = 0;
    for (const std::uint64_t voxels : block.voxels) count += std::popcount(voxels);
    for (int level = 1; level < kBalanceBlockLevel; ++level) {
      const int side = cells_along(level);
      for (int row = 0; row < side * side; ++row) {
        const std::size_t at = first_row(level) + static_cast<std::size_t>(row);
        std::uint32_t above = (1u << side) - 1;  // rows may have other bits behind their cells
        if (level + 1 < kBalanceBlockLevel) {
          const int row_above = row / side / 2 * (side / 2) + row % side / 2;
          above &= doubled_row(
              block.split[first_row(level + 1) + static_cast<std::size_t>(row_above)]);
        }
        count += std::popcount(block.full[at] & ~std::uint32_t{block.split[at]} & above);
      }
    }
    return static_cast<std::size_t>(count);
  }

  static bool is_cell(const std::array<std::uint8_t, 84>& rows, int level, std::uint64_t code) {
    const CellPlace& cell = kCellPlaces[code];
    return (rows[first_row(level) + static_cast<std::size_t>(cell.z * cells_along(level) +
                                                             cell.y)] >>
                cell.x & 1) != 0;
  }

  /// Puts the leaves of a block that is split where there is room for all of them.
  static void put_leaves(const BalanceBlock& block, OCode* out) {
    for (std::uint64_t large = 0; large < 8; ++large) {
      if (!is_cell(block.split, 3, large)) {
        if (is_cell(block.full, 3, large)) *out++ = {3, block.code << 3 | large};
        continue;
      }
      for (std::uint64_t code = 8 * large; code < 8 * large + 8; ++code) {
        if (is_cell(block.split, 2, code)) out = put_small_leaves(block, code, out);
        else if (is_cell(block.full, 2, code)) *out++ = {2, block.code << 6 | code};
      }
    }
  }

  /// The same of a cell of level 2, whose voxels are a word.
  static OCode* put_small_leaves(const BalanceBlock& block, std::uint64_t cell, OCode* out) {
    const std::uint64_t word = block.voxels[cell];
    const std::uint64_t base = block.code << 12 | cell << 6;
    for (std::uint64_t octant = 0; octant < 8; ++octant) {
      const std::uint64_t code = cell << 3 | octant;
      std::uint64_t left = word >> 8 * octant & 0xff;
      if (left == 0 && is_cell(block.full, 1, code)) *out++ = {1, block.code << 9 | code};
      for (; left != 0; left &= left - 1) {
        *out++ = {0, base | octant << 3 | static_cast<std::uint64_t>(std::countr_zero(left))};
      }
    }
    return out;
  }

  std::vector<BalanceBlock> blocks_;
  std::unordered_map<std::uint64_t, std::size_t> places_;
  std::size_t last_ = 0;
  std::vector<OCode> large_leaves_;
  std::vector<std::unordered_set<std::uint64_t>> large_;  ///< by level
  std::vector<std::unordered_set<std::uint64_t>> split_;  ///< by level, blocks and above
};

LeafBalance::LeafBalance() : blocks_(std::make_unique<Blocks>()) {}
LeafBalance::~LeafBalance() = default;

void LeafBalance::add(const OCode& leaf) { blocks_->add(leaf); }

std::uint64_t LeafBalance::memory_bytes() const noexcept { return blocks_->memory_bytes(); }

std::vector<OCode> LeafBalance::finish(const Progress& watcher) {
  return blocks_->finish(watcher);
}

}  // namespace octavo
