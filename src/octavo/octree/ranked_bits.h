// A row of bits that tells how many are set before any of them.
//
// Source  Jacobson, Space-efficient static trees and graphs, 1989
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

namespace octavo {

/// Bits in words of 64, with the count of those set before each word: 2 bits of memory per bit.
class RankedBits {
 public:
  void push_back(bool is_set) {
    if (size_ % 64 == 0) {
      words_.push_back(0);
      before_.push_back(count_);
    }
    words_.back() |= static_cast<std::uint64_t>(is_set) << size_ % 64;
    count_ += is_set ? 1 : 0;
    ++size_;
  }

  void reserve(std::uint64_t size) {
    words_.reserve(size / 64 + 1);
    before_.reserve(size / 64 + 1);
  }

  std::uint64_t size() const noexcept { return size_; }
  std::uint64_t count() const noexcept { return count_; }
  bool operator==(const RankedBits&) const = default;

  std::uint64_t memory_bytes() const noexcept {
    return (words_.capacity() + before_.capacity()) * sizeof(std::uint64_t);
  }

  /// Requires i < size().
  bool operator[](std::uint64_t i) const noexcept { return (words_[i / 64] >> i % 64 & 1) != 0; }

  /// How many bits are set before bit i. Requires i < size().
  std::uint64_t rank(std::uint64_t i) const noexcept {
    const std::uint64_t below = words_[i / 64] & ((std::uint64_t{1} << i % 64) - 1);
    return before_[i / 64] + static_cast<std::uint64_t>(std::popcount(below));
  }

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint64_t> before_;
  std::uint64_t size_ = 0;
  std::uint64_t count_ = 0;
};

}  // namespace octavo
