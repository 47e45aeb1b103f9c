// Points that are known to belong together, and the blocks that their pieces go on in.
//
// Every piece keeps the blocks that wait for it. Of two that are joined the shorter list goes into
// the longer one, so what waits for other pieces costs nothing when those of one piece are taken:
// n notes cost n log n steps in all.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "octavo/core/joined_sets.h"

namespace octavo {

class PieceSets {
 public:
  /// Points up to `count`, each a piece of its own.
  void grow_to(std::size_t count) {
    sets_.grow_to(count);
    lists_of_.resize(std::max(lists_of_.size(), count), kNone);
  }

  std::uint32_t first_of(std::uint32_t point) { return sets_.first_of(point); }

  void join(std::uint32_t a, std::uint32_t b) {
    a = first_of(a);
    b = first_of(b);
    if (a == b) return;
    sets_.join(a, b);
    const auto [first, other] = std::minmax(a, b);
    lists_of_[first] = joined(lists_of_[first], std::exchange(lists_of_[other], kNone));
  }

  /// The piece of a point goes on in a block.
  void note(std::uint32_t point, std::uint32_t block) {
    std::uint32_t& own = lists_of_[first_of(point)];
    if (own == kNone) own = free_list();
    List& list = lists_[own];
    if (!list.blocks.empty() && list.blocks.back() == block) return;
    list.blocks.push_back(block);
    ++steps_;
    if (list.blocks.size() > list.shortest) shorten(list);
  }

  /// The blocks that were noted for the piece of a point, ascending; they no longer wait for it.
  std::vector<std::uint32_t> take(std::uint32_t point) {
    const std::uint32_t own = std::exchange(lists_of_[first_of(point)], kNone);
    if (own == kNone) return {};
    shorten(lists_[own]);
    std::vector<std::uint32_t> blocks = std::exchange(lists_[own], List{}).blocks;
    free_.push_back(own);
    return blocks;
  }

  /// Blocks that were noted, moved between lists or sorted up to now.
  std::uint64_t steps() const { return steps_; }

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  static constexpr std::size_t kShort = 64;

  struct List {
    std::vector<std::uint32_t> blocks;
    std::size_t shortest = kShort;  // beyond it repeated blocks are looked for
  };

  std::uint32_t free_list() {
    if (free_.empty()) {
      lists_.emplace_back();
      return static_cast<std::uint32_t>(lists_.size() - 1);
    }
    const std::uint32_t list = free_.back();
    free_.pop_back();
    return list;
  }

  std::uint32_t joined(std::uint32_t a, std::uint32_t b) {
    if (a == kNone || b == kNone) return a == kNone ? b : a;
    if (lists_[a].blocks.size() < lists_[b].blocks.size()) std::swap(a, b);
    std::vector<std::uint32_t> moved = std::exchange(lists_[b], List{}).blocks;
    free_.push_back(b);
    List& list = lists_[a];
    list.blocks.insert(list.blocks.end(), moved.begin(), moved.end());
    steps_ += moved.size();
    if (list.blocks.size() > list.shortest) shorten(list);
    return a;
  }

  void shorten(List& list) {
    steps_ += list.blocks.size();
    std::sort(list.blocks.begin(), list.blocks.end());
    list.blocks.erase(std::unique(list.blocks.begin(), list.blocks.end()), list.blocks.end());
    list.shortest = std::max(kShort, 2 * list.blocks.size());
  }

  JoinedSets<std::uint32_t> sets_;
  std::vector<std::uint32_t> lists_of_;  // of the first point of a piece
  std::vector<List> lists_;
  std::vector<std::uint32_t> free_;
  std::uint64_t steps_ = 0;
};

}  // namespace octavo
