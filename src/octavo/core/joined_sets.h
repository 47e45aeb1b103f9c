// Sets of numbers that are joined, until only those stay apart that nothing joins.
#pragma once

#include <cstddef>
#include <numeric>
#include <vector>

namespace octavo {

/// Each of the numbers 0 .. count - 1 is a set of its own until it is joined; the smallest member
/// stands for a set.
/// Memory  a Number for each
template <class Number>
class JoinedSets {
 public:
  explicit JoinedSets(std::size_t count = 0) { grow_to(count); }

  /// As many numbers as that, the new ones each a set of its own; never fewer than before.
  void grow_to(std::size_t count) {
    const std::size_t before = parents_.size();
    if (count <= before) return;
    parents_.resize(count);
    std::iota(parents_.begin() + static_cast<std::ptrdiff_t>(before), parents_.end(),
              static_cast<Number>(before));
  }

  /// The member that stands for the set of one.
  Number first_of(Number member) {
    while (parents_[member] != member) {
      parents_[member] = parents_[parents_[member]];
      member = parents_[member];
    }
    return member;
  }

  void join(Number a, Number b) {
    a = first_of(a);
    b = first_of(b);
    if (a < b) parents_[b] = a;
    else parents_[a] = b;
  }

 private:
  std::vector<Number> parents_;
};

}  // namespace octavo
