// Numbers and texts at fixed places of a binary header.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <span>
#include <string>

#include "octavo/io/source/byte_order.h"

namespace octavo {

/// A header of known length. Requires that every place asked for lies within it.
class HeaderBytes {
 public:
  HeaderBytes(std::span<const std::byte> bytes, bool big_endian)
      : bytes_(bytes), swap_(needs_swap(big_endian)) {}

  /// The number at `offset`.
  template <class T>
  T at(std::size_t offset) const {
    std::array<std::byte, sizeof(T)> raw{};
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), raw.begin());
    if (swap_) std::reverse(raw.begin(), raw.end());
    T value;
    std::memcpy(&value, raw.data(), sizeof(T));
    return value;
  }

  /// Fills `target` with numbers of type T that follow one another.
  template <class T, class Array>
  void fill(std::size_t offset, Array& target) const {
    for (std::size_t i = 0; i < target.size(); ++i) {
      target[i] = static_cast<typename Array::value_type>(at<T>(offset + i * sizeof(T)));
    }
  }

  /// At most `length` bytes, up to the first zero.
  std::string text(std::size_t offset, std::size_t length) const {
    std::string text(reinterpret_cast<const char*>(bytes_.data()) + offset, length);
    text.resize(std::min(text.find('\0'), length));
    return text;
  }

 private:
  std::span<const std::byte> bytes_;
  bool swap_;
};

}  // namespace octavo
