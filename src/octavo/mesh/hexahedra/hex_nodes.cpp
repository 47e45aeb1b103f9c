#include "octavo/mesh/hexahedra/hex_nodes.h"

#include <algorithm>
#include <atomic>
#include <string>

#include "octavo/core/error.h"
#include "octavo/mesh/cancellation.h"
#include "octavo/threads/parallel_for.h"
#include "octavo/threads/per_thread.h"

namespace octavo {

namespace {

/// Four bits of a coordinate, two zeros between.
constexpr std::array<std::uint16_t, 16> kSpreadBits = [] {
  std::array<std::uint16_t, 16> spread{};
  for (unsigned i = 0; i < 16; ++i) {
    spread[i] = static_cast<std::uint16_t>((i & 1) | (i & 2) << 2 | (i & 4) << 4 | (i & 8) << 6);
  }
  return spread;
}();

NodePlace node_place(const GridPoint& point) {
  const std::uint32_t code = static_cast<std::uint32_t>(kSpreadBits[point[1] & 15]) |
                             static_cast<std::uint32_t>(kSpreadBits[point[0] & 15]) << 1 |
                             static_cast<std::uint32_t>(kSpreadBits[point[2] & 15]) << 2;
  return {code >> 6, std::uint64_t{1} << (code & 63)};
}

GridPoint stepped(const GridPoint& from, std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return {from[0] + x, from[1] + y, from[2] + z};
}

/// The point 0, 1 or 2 half sides from the corner of a cell.
GridPoint point_of(const HexCell& cell, std::uint32_t number) {
  const std::uint32_t half = cell.side() / 2;
  return stepped(cell.corner, number % 3 * half, number / 3 % 3 * half, number / 9 * half);
}

/// Where points of a cell lie that are some steps along each axis from its corner: the bits of
/// their places in a block, and by how much the block comes behind that of the corner.
class CellPlaces {
 public:
  /// Of a cell whose steps reach into the next blocks at most.
  CellPlaces(const HexCell& cell, std::uint32_t step, std::uint32_t count) {
    constexpr std::array<unsigned, 3> kShifts = {1, 0, 2};  // of x, y and z
    for (std::size_t axis = 0; axis < 3; ++axis) {
      std::uint32_t at = cell.corner[axis] & 15;
      for (std::size_t i = 0; i < count; ++i, at += step) {
        codes_[axis][i] = static_cast<std::uint32_t>(kSpreadBits[at & 15]) << kShifts[axis];
        blocks_[axis][i] = at >> 4 << axis;
      }
    }
  }

  NodePlace place(std::size_t x, std::size_t y, std::size_t z) const {
    const std::uint32_t code = codes_[0][x] | codes_[1][y] | codes_[2][z];
    return {code >> 6, std::uint64_t{1} << (code & 63)};
  }
  /// Which of the eight blocks from that of the corner on.
  std::size_t block(std::size_t x, std::size_t y, std::size_t z) const {
    return blocks_[0][x] | blocks_[1][y] | blocks_[2][z];
  }

 private:
  std::array<std::array<std::uint32_t, 3>, 3> codes_;
  std::array<std::array<std::uint32_t, 3>, 3> blocks_;
};

/// The points of larger cells lie farther away than in the next blocks.
constexpr int kLargestNear = 4;

/// The points of a cell, as numbers of [z][y][x], that are neither a corner nor the center.
constexpr std::array<std::uint32_t, 18> kMiddles = {1,  3,  4,  5,  7,  9,  10, 11, 12,
                                                    14, 15, 16, 17, 19, 21, 22, 23, 25};

GridPoint corner_point(const HexCell& cell, std::size_t number) {
  const auto& step = kHexCorners[number];
  const std::uint32_t side = cell.side();
  return stepped(cell.corner, step[0] * side, step[1] * side, step[2] * side);
}

bool is_same(const GridPoint& a, const GridPoint& b) {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

GridPoint node_block(const GridPoint& point) {
  return {point[0] >> 4, point[1] >> 4, point[2] >> 4};
}

std::uint64_t code_of_block(const GridPoint& block) {
  return interleave({block[0], block[1], block[2]});
}

/// Sets a bit that several threads may set at once; most have been set by a cell before.
void set_shared(std::uint64_t& word, std::uint64_t bit) {
  const std::atomic_ref<std::uint64_t> shared(word);
  if ((shared.load(std::memory_order_relaxed) & bit) != 0) return;
  shared.fetch_or(bit, std::memory_order_relaxed);
}

/// Calls work(part) for pieces of the cells, on all threads.
template <class Work>
void for_each_part(std::span<const HexCell> cells, const Progress& watcher, Work&& work) {
  constexpr std::size_t kCellsOfPart = 4096;
  parallel_parts(std::size_t{0}, cells.size(), kCellsOfPart,
                 [&](std::size_t begin, std::size_t end) {
                   stop_if_cancelled(watcher);
                   work(cells.subspan(begin, end - begin));
                 });
}

/// The blocks that hold corners of cells, each once in the end.
class BlockCodes {
 public:
  void add(const HexCell& cell) {
    const std::uint32_t side = cell.side();
    const GridPoint low = node_block(cell.corner);
    const GridPoint high = node_block(stepped(cell.corner, side, side, side));
    const std::uint32_t beyond = (low[0] < high[0] ? 1u : 0u) | (low[1] < high[1] ? 2u : 0u) |
                                 (low[2] < high[2] ? 4u : 0u);
    if (side > 16) {
      take(low, high, beyond);
      return;
    }
    if (!is_same(low, low_)) {
      take_last();
      low_ = low;
    }
    beyond_ |= 1u << beyond;
  }

  const std::vector<std::uint64_t>& sorted() {
    take_last();
    sort();
    return codes_;
  }

 private:
  void sort() {
    std::sort(codes_.begin(), codes_.end());
    codes_.erase(std::unique(codes_.begin(), codes_.end()), codes_.end());
    longest_ = std::max(kShort, 2 * codes_.size());
  }

  /// The blocks of the cells that have had their corners in the same one.
  void take_last() {
    for (std::uint32_t i = 0; i < 8; ++i) {
      if ((beyond_ >> i & 1) != 0) take(low_, stepped(low_, 1, 1, 1), i);
    }
    beyond_ = 0;
  }

  /// The blocks of corners; bit k of `beyond`: not all are alike along axis k.
  void take(const GridPoint& low, const GridPoint& high, std::uint32_t beyond) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      if ((i & ~beyond) != 0) continue;
      codes_.push_back(code_of_block({(i & 1) != 0 ? high[0] : low[0],
                                      (i & 2) != 0 ? high[1] : low[1],
                                      (i & 4) != 0 ? high[2] : low[2]}));
    }
    if (codes_.size() > longest_) sort();
  }

  static constexpr std::size_t kShort = 4096;

  GridPoint low_ = {HexNodes::kNone, HexNodes::kNone, HexNodes::kNone};
  std::uint32_t beyond_ = 0;  // bit i: a cell reaches into the next blocks along the axes of i
  std::vector<std::uint64_t> codes_;
  std::size_t longest_ = kShort;
};

}  // namespace

HexNodes::HexNodes(std::span<const HexCell> cells, const Progress& watcher) {
  make_blocks(cells, watcher);
  set_corners(cells, watcher);
  find_hanging(cells, watcher);
  number_nodes();
}

void HexNodes::make_blocks(std::span<const HexCell> cells, const Progress& watcher) {
  PerThread<BlockCodes> spaces;
  for_each_part(cells, watcher, [&](std::span<const HexCell> part) {
    BlockCodes& codes = spaces.local();
    for (const HexCell& cell : part) codes.add(cell);
  });
  std::vector<std::uint64_t> all;
  for (BlockCodes& codes : spaces) {
    const std::vector<std::uint64_t>& some = codes.sorted();
    all.insert(all.end(), some.begin(), some.end());
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  blocks_.resize(all.size());
  places_.reserve(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    blocks_[i].code = all[i];
    places_.emplace(all[i], static_cast<std::uint32_t>(i));
  }
}

std::uint32_t HexNodes::find(const GridPoint& block) const noexcept {
  const auto found = places_.find(code_of_block(block));
  return found == places_.end() ? kNone : found->second;
}

void HexNodes::look_around(const HexCell& cell, Near& near) const noexcept {
  const GridPoint lowest = node_block(cell.corner);
  if (is_same(near.at, lowest)) return;
  near.at = lowest;
  for (std::uint32_t i = 0; i < 8; ++i) {
    near.blocks[i] = find(stepped(lowest, i & 1, i >> 1 & 1, i >> 2));
  }
}

std::uint32_t HexNodes::block_of(const GridPoint& point, const Near& near) const noexcept {
  const GridPoint block = node_block(point);
  const std::uint32_t x = block[0] - near.at[0];
  const std::uint32_t y = block[1] - near.at[1];
  const std::uint32_t z = block[2] - near.at[2];
  if ((x | y | z) > 1) return find(block);
  return near.blocks[x | y << 1 | z << 2];
}

/// Calls visit(place in kHexCorners, block, place in that block) for the corners of a cell, around
/// which we have looked.
template <class Visit>
void HexNodes::visit_corners(const HexCell& cell, const Near& near, Visit&& visit) const {
  if (cell.level <= kLargestNear) {
    const CellPlaces places(cell, cell.side(), 2);
    for (std::size_t i = 0; i < 8; ++i) {
      const auto& [x, y, z] = kHexCorners[i];
      visit(i, near.blocks[places.block(x, y, z)], places.place(x, y, z));
    }
    return;
  }
  for (std::size_t i = 0; i < 8; ++i) {
    const GridPoint point = corner_point(cell, i);
    visit(i, block_of(point, near), node_place(point));
  }
}

/// The same for its middles, with numbers as in kMiddles.
template <class Visit>
void HexNodes::visit_middles(const HexCell& cell, const Near& near, Visit&& visit) const {
  if (cell.level <= kLargestNear) {
    const CellPlaces places(cell, cell.side() / 2, 3);
    for (const std::uint32_t middle : kMiddles) {
      const std::size_t x = middle % 3;
      const std::size_t y = middle / 3 % 3;
      const std::size_t z = middle / 9;
      visit(middle, near.blocks[places.block(x, y, z)], places.place(x, y, z));
    }
    return;
  }
  for (const std::uint32_t middle : kMiddles) {
    const GridPoint point = point_of(cell, middle);
    visit(middle, block_of(point, near), node_place(point));
  }
}

void HexNodes::set_corners(std::span<const HexCell> cells, const Progress& watcher) {
  for_each_part(cells, watcher, [&](std::span<const HexCell> part) {
    Near near;
    for (const HexCell& cell : part) {
      look_around(cell, near);
      visit_corners(cell, near, [&](std::size_t, std::uint32_t block, const NodePlace& place) {
        set_shared(blocks_[block].nodes[0][place.word], place.bit);
      });
    }
  });
}

void HexNodes::number_nodes() {
  if (count_ > kMostHexNodes) {
    throw Error(ErrorKind::limit_exceeded,
                "the mesh has " + std::to_string(count_) + " nodes; solvers number 2147483647")
        .with_field("level");
  }
  std::array<std::uint64_t, 2> next = {0, count_ - hanging_count_};
  for (Block& block : blocks_) {
    for (std::size_t kind = 0; kind < 2; ++kind) {
      for (std::size_t word = 0; word < 64; ++word) {
        block.first[kind][word] = static_cast<std::uint32_t>(next[kind]);
        next[kind] += static_cast<std::uint64_t>(std::popcount(block.nodes[kind][word]));
      }
    }
  }
}

std::uint32_t HexNodes::number_in(std::uint32_t block, const NodePlace& place) const noexcept {
  if (block == kNone) return kNone;
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const std::uint64_t nodes = blocks_[block].nodes[kind][place.word];
    if ((nodes & place.bit) == 0) continue;
    return blocks_[block].first[kind][place.word] +
           static_cast<std::uint32_t>(std::popcount(nodes & (place.bit - 1)));
  }
  return kNone;
}

std::uint32_t HexNodes::number_at(const GridPoint& point) const noexcept {
  return number_in(find(node_block(point)), node_place(point));
}

std::array<std::uint32_t, 8> HexNodes::corners_of(const HexCell& cell, Near& near) const noexcept {
  look_around(cell, near);
  std::array<std::uint32_t, 8> numbers{};
  visit_corners(cell, near, [&](std::size_t i, std::uint32_t block, const NodePlace& place) {
    numbers[i] = number_in(block, place);
  });
  return numbers;
}

HexMasters HexNodes::masters_of(const GridPoint& point) const noexcept {
  const std::uint32_t step = std::uint32_t{1} << std::countr_zero(point[0] | point[1] | point[2]);
  HexMasters masters{{number_at(point), 0, 0, 0}, 1};
  std::array<GridPoint, 4> at = {point};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if ((point[axis] & step) == 0 || masters.count > 2) continue;
    for (int i = 0; i < masters.count; ++i) {
      const auto from = static_cast<std::size_t>(i);
      const auto to = static_cast<std::size_t>(i + masters.count);
      at[to] = at[from];
      at[to][axis] += step;
      at[from][axis] -= step;
    }
    masters.count *= 2;
  }
  for (std::size_t i = 0; i < static_cast<std::size_t>(masters.count); ++i) {
    masters.nodes[i] = number_at(at[i]);
  }
  return masters;
}

std::uint32_t HexNodes::points_of(const HexCell& cell, Near& near) const noexcept {
  look_around(cell, near);
  std::uint32_t points = kCornerPoints;
  visit_middles(cell, near, [&](std::uint32_t i, std::uint32_t block, const NodePlace& place) {
    if (number_in(block, place) != kNone) points |= 1u << i;
  });
  return points;
}

void HexNodes::find_hanging(std::span<const HexCell> cells, const Progress& watcher) {
  for_each_part(cells, watcher, [&](std::span<const HexCell> part) {
    Near near;
    for (const HexCell& cell : part) {
      if (cell.level == 0) continue;
      look_around(cell, near);
      visit_middles(cell, near, [&](std::uint32_t, std::uint32_t block, const NodePlace& place) {
        if (block == kNone) return;
        auto& nodes = blocks_[block].nodes;
        if ((nodes[0][place.word] & place.bit) != 0) {
          set_shared(nodes[1][place.word], place.bit);
        }
      });
    }
  });
  for (Block& block : blocks_) {
    for (std::size_t word = 0; word < 64; ++word) {
      block.nodes[0][word] &= ~block.nodes[1][word];
      const auto hanging = static_cast<std::uint64_t>(std::popcount(block.nodes[1][word]));
      hanging_count_ += hanging;
      count_ += hanging + static_cast<std::uint64_t>(std::popcount(block.nodes[0][word]));
    }
  }
}

}  // namespace octavo
