// A heap of numbered things by their costs, the lowest first.
//
// Costs of 0 and more are ordered as floats as they are as integers of their bits. So an entry is
// one integer: the cost above, the number below. Things of the same cost come by their numbers.
// Four children to an entry make the heap half as deep as two do.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace octavo {

class CostHeap {
 public:
  bool is_empty() const { return entries_.empty(); }
  void clear() { entries_.clear(); }

  /// Requires cost >= 0, not NaN.
  void push(float cost, std::uint32_t number) {
    const std::uint64_t entry = std::uint64_t{std::bit_cast<std::uint32_t>(cost + 0.0f)} << 32 |
                                number;
    entries_.push_back(entry);
    std::uint64_t* const entries = entries_.data();
    std::size_t at = entries_.size() - 1;
    while (at > 0) {
      const std::size_t parent = (at - 1) / kChildren;
      if (entries[parent] <= entry) break;
      entries[at] = entries[parent];
      at = parent;
    }
    entries[at] = entry;
  }

  /// The number of the thing with the lowest cost, which is taken out. Requires that there is one.
  std::uint32_t pop() {
    std::uint64_t* const entries = entries_.data();
    const auto lowest = static_cast<std::uint32_t>(entries[0]);
    const std::uint64_t last = entries_.back();
    entries_.pop_back();
    const std::size_t count = entries_.size();
    if (count == 0) return lowest;
    std::size_t at = 0;
    for (std::size_t child = 1; child < count; child = kChildren * at + 1) {
      std::uint64_t smallest = entries[child];
      const std::size_t end = child + kChildren < count ? child + kChildren : count;
      std::size_t first = child;
      for (std::size_t i = child + 1; i < end; ++i) {
        first = entries[i] < smallest ? i : first;
        smallest = entries[i] < smallest ? entries[i] : smallest;
      }
      if (smallest >= last) break;
      entries[at] = smallest;
      at = first;
    }
    entries[at] = last;
    return lowest;
  }

 private:
  static constexpr std::size_t kChildren = 4;

  std::vector<std::uint64_t> entries_;
};

}  // namespace octavo
