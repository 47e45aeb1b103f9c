#include "octavo/mesh/hexahedra/hex_nodes.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "octavo/core/error.h"

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

/// Of a point in its block.
struct NodePlace {
  std::size_t word = 0;
  std::uint64_t bit = 0;
};

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

/// The points of a cell, as numbers of [z][y][x], that are neither a corner nor the center.
constexpr std::array<std::uint32_t, 18> kMiddles = {1,  3,  4,  5,  7,  9,  10, 11, 12,
                                                    14, 15, 16, 17, 19, 21, 22, 23, 25};

GridPoint corner_point(const HexCell& cell, std::size_t number) {
  const auto& step = kHexCorners[number];
  const std::uint32_t side = cell.side();
  return stepped(cell.corner, step[0] * side, step[1] * side, step[2] * side);
}

GridPoint node_block(const GridPoint& point) {
  return {point[0] >> 4, point[1] >> 4, point[2] >> 4};
}

std::uint64_t code_of_block(const GridPoint& block) {
  return interleave({block[0], block[1], block[2]});
}

}  // namespace

HexNodes::HexNodes(std::span<const HexCell> cells) {
  set_corners(cells);
  find_hanging(cells);
  number_nodes();
}

std::uint32_t HexNodes::made(const GridPoint& block) {
  const std::uint64_t code = code_of_block(block);
  const auto [place, is_new] =
      places_.try_emplace(code, static_cast<std::uint32_t>(blocks_.size()));
  if (is_new) blocks_.emplace_back().code = code;
  return place->second;
}

std::uint32_t HexNodes::find(const GridPoint& block) const noexcept {
  const auto found = places_.find(code_of_block(block));
  return found == places_.end() ? kNone : found->second;
}

void HexNodes::look_around(const HexCell& cell, Near& near) const noexcept {
  const GridPoint lowest = node_block(cell.corner);
  if (near.at == lowest) return;
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

void HexNodes::set_corners(std::span<const HexCell> cells) {
  Near near;
  for (const HexCell& cell : cells) {
    look_around(cell, near);
    for (std::size_t i = 0; i < 8; ++i) {
      const GridPoint point = corner_point(cell, i);
      std::uint32_t block = block_of(point, near);
      if (block == kNone) {
        block = made(node_block(point));
        near.at = {kNone, kNone, kNone};
        look_around(cell, near);
      }
      const auto [word, bit] = node_place(point);
      blocks_[block].nodes[0][word] |= bit;
    }
  }
}

void HexNodes::number_nodes() {
  if (count_ > kMostHexNodes) {
    throw Error(ErrorKind::limit_exceeded,
                "the mesh has " + std::to_string(count_) + " nodes; solvers number 2147483647")
        .with_field("level");
  }
  // Blocks are large: each is moved once.
  std::vector<std::uint32_t> order(blocks_.size());
  std::iota(order.begin(), order.end(), std::uint32_t{0});
  std::sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
    return blocks_[a].code < blocks_[b].code;
  });
  std::vector<Block> sorted;
  sorted.reserve(blocks_.size());
  for (const std::uint32_t place : order) sorted.push_back(blocks_[place]);
  blocks_ = std::move(sorted);

  std::array<std::uint64_t, 2> next = {0, count_ - hanging_count_};
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    places_[block.code] = static_cast<std::uint32_t>(i);
    for (std::size_t kind = 0; kind < 2; ++kind) {
      for (std::size_t word = 0; word < 64; ++word) {
        block.first[kind][word] = static_cast<std::uint32_t>(next[kind]);
        next[kind] += static_cast<std::uint64_t>(std::popcount(block.nodes[kind][word]));
      }
    }
  }
}

std::uint32_t HexNodes::number_in(std::uint32_t block, const GridPoint& point) const noexcept {
  if (block == kNone) return kNone;
  const auto [word, bit] = node_place(point);
  for (std::size_t kind = 0; kind < 2; ++kind) {
    const std::uint64_t nodes = blocks_[block].nodes[kind][word];
    if ((nodes & bit) == 0) continue;
    return blocks_[block].first[kind][word] +
           static_cast<std::uint32_t>(std::popcount(nodes & (bit - 1)));
  }
  return kNone;
}

std::uint32_t HexNodes::number_at(const GridPoint& point) const noexcept {
  return number_in(find(node_block(point)), point);
}

std::array<std::uint32_t, 8> HexNodes::corners_of(const HexCell& cell, Near& near) const noexcept {
  look_around(cell, near);
  std::array<std::uint32_t, 8> numbers{};
  for (std::size_t i = 0; i < 8; ++i) {
    const GridPoint point = corner_point(cell, i);
    numbers[i] = number_in(block_of(point, near), point);
  }
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
  for (const std::uint32_t middle : kMiddles) {
    const GridPoint point = point_of(cell, middle);
    if (number_in(block_of(point, near), point) != kNone) points |= 1u << middle;
  }
  return points;
}

void HexNodes::find_hanging(std::span<const HexCell> cells) {
  Near near;
  for (const HexCell& cell : cells) {
    if (cell.level == 0) continue;
    look_around(cell, near);
    for (const std::uint32_t middle : kMiddles) {
      const GridPoint point = point_of(cell, middle);
      const std::uint32_t block = block_of(point, near);
      if (block == kNone) continue;
      auto& nodes = blocks_[block].nodes;
      const auto [word, bit] = node_place(point);
      const std::uint64_t found = bit & nodes[0][word];
      nodes[0][word] &= ~found;
      nodes[1][word] |= found;
    }
  }
  for (const Block& block : blocks_) {
    for (std::size_t word = 0; word < 64; ++word) {
      const auto hanging = static_cast<std::uint64_t>(std::popcount(block.nodes[1][word]));
      hanging_count_ += hanging;
      count_ += hanging + static_cast<std::uint64_t>(std::popcount(block.nodes[0][word]));
    }
  }
}

}  // namespace octavo
