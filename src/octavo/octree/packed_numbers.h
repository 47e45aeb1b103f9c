// An array of numbers in as few bytes each as the largest needs.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace octavo {

/// Numbers below 2^32 in 0, 1, 2 or 4 bytes each; 0 bytes where all are 0. Equal arrays of numbers
/// have equal bytes.
class PackedNumbers {
 public:
  PackedNumbers() = default;

  /// Throws std::bad_alloc.
  explicit PackedNumbers(std::span<const std::uint32_t> numbers)
      : PackedNumbers(numbers.size(), numbers.empty() ? 0 : *std::ranges::max_element(numbers)) {
    for (std::size_t i = 0; i < numbers.size(); ++i) set(i, numbers[i]);
  }

  /// As many zeros, in the width that `largest` needs. To be filled by `set`, and one of them with
  /// `largest`.
  PackedNumbers(std::uint64_t size, std::uint32_t largest)
      : size_(size), width_(width_for(largest)), bytes_(static_cast<std::size_t>(size) * width_) {}

  std::uint64_t size() const noexcept { return size_; }
  bool operator==(const PackedNumbers&) const = default;

  /// Bytes of a number.
  std::size_t width() const noexcept { return width_; }
  std::uint64_t memory_bytes() const noexcept { return bytes_.capacity(); }

  /// Requires i < size().
  std::uint32_t operator[](std::uint64_t i) const noexcept {
    switch (width_) {
      case 0: return 0;
      case 1: return load<std::uint8_t>(i);
      case 2: return load<std::uint16_t>(i);
      default: return load<std::uint32_t>(i);
    }
  }

  /// Requires i < size() and a number not above the largest.
  void set(std::uint64_t i, std::uint32_t number) noexcept {
    switch (width_) {
      case 0: return;
      case 1: return store(i, static_cast<std::uint8_t>(number));
      case 2: return store(i, static_cast<std::uint16_t>(number));
      default: return store(i, number);
    }
  }

 private:
  static std::size_t width_for(std::uint32_t largest) {
    return largest == 0 ? 0 : largest <= 0xff ? 1 : largest <= 0xffff ? 2 : 4;
  }

  template <class T>
  T load(std::uint64_t i) const noexcept {
    T number;
    std::memcpy(&number, bytes_.data() + i * sizeof(T), sizeof(T));
    return number;
  }

  template <class T>
  void store(std::uint64_t i, T number) noexcept {
    std::memcpy(bytes_.data() + i * sizeof(T), &number, sizeof(T));
  }

  std::uint64_t size_ = 0;
  std::size_t width_ = 0;
  std::vector<std::uint8_t> bytes_;
};

}  // namespace octavo
