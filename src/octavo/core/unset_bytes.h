// Bytes that take memory as they are written.
#pragma once

#include <cstddef>
#include <memory>
#include <span>

namespace octavo {

/// A buffer whose bytes have no value before they are written. Nothing is set to 0 in advance: a
/// large one takes memory page by page, so that what is never filled costs nothing.
class UnsetBytes {
 public:
  UnsetBytes() = default;
  explicit UnsetBytes(std::size_t size) { resize(size); }

  /// No byte keeps its value where more are asked for than ever before.
  void resize(std::size_t size) {
    if (size > capacity_) {
      bytes_.reset();
      capacity_ = 0;
      bytes_.reset(new std::byte[size]);
      capacity_ = size;
    }
    size_ = size;
  }

  std::byte* data() { return bytes_.get(); }
  const std::byte* data() const { return bytes_.get(); }
  std::size_t size() const { return size_; }
  std::size_t capacity() const { return capacity_; }
  std::span<std::byte> bytes() { return {bytes_.get(), size_}; }
  std::span<const std::byte> bytes() const { return {bytes_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> bytes_;
  std::size_t capacity_ = 0;
  std::size_t size_ = 0;
};

}  // namespace octavo
