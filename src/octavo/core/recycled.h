// Buffers that threads are done with, for whoever needs one next.
//
// Allocators give large memory back to the system, which clears it and gives it anew page by page.
// For buffers that live as long as a brick is decoded that takes a tenth as long as decoding it.
#pragma once

#include <array>
#include <cstddef>
#include <utility>

#include "octavo/core/bytes.h"
#include "octavo/core/unset_bytes.h"

namespace octavo {

inline std::size_t capacity_of(const Bytes& buffer) { return buffer.capacity(); }
inline std::size_t capacity_of(const UnsetBytes& buffer) { return buffer.capacity(); }
template <class Buffer, std::size_t kCount>
std::size_t capacity_of(const std::array<Buffer, kCount>& buffers) {
  std::size_t sum = 0;
  for (const Buffer& buffer : buffers) sum += capacity_of(buffer);
  return sum;
}

/// A buffer of the thread that makes it, which goes to the thread that destroys it; its contents
/// are anything, or what it was made of.
/// Use     whoever shares buffers of one size: they grow to the largest that is asked for
/// Memory  a thread keeps at most kMostKept of each use, none above kMostBytes
template <class Buffer, class Use>
class Recycled {
 public:
  static constexpr std::size_t kMostKept = 8;
  static constexpr std::size_t kMostBytes = std::size_t{1} << 19;

  Recycled() {
    Kept* const own = kept();
    if (own != nullptr && own->count > 0) buffer_ = std::move(own->buffers[--own->count]);
  }
  Recycled(Recycled&& other) noexcept : buffer_(std::exchange(other.buffer_, Buffer{})) {}
  Recycled& operator=(Recycled&& other) noexcept {
    std::swap(buffer_, other.buffer_);
    return *this;
  }
  ~Recycled() {
    const std::size_t bytes = capacity_of(buffer_);
    if (bytes == 0 || bytes > kMostBytes) return;
    Kept* const own = kept();
    if (own != nullptr && own->count < kMostKept) own->buffers[own->count++] = std::move(buffer_);
  }

  /// Makes room for so many bytes, but not of a buffer more than twice as large, which goes back
  /// to the system: for what is held for long, by caches that count what they asked for.
  void hold(std::size_t bytes) {
    if (capacity_of(buffer_) / 2 > bytes) buffer_ = Buffer();
    buffer_.resize(bytes);
  }

  Buffer& operator*() { return buffer_; }
  const Buffer& operator*() const { return buffer_; }
  Buffer* operator->() { return &buffer_; }
  const Buffer* operator->() const { return &buffer_; }

 private:
  struct Kept {
    std::array<Buffer, kMostKept> buffers;
    std::size_t count = 0;
    bool* is_gone;

    explicit Kept(bool* gone) : is_gone(gone) {}
    Kept(const Kept&) = delete;
    Kept& operator=(const Kept&) = delete;
    ~Kept() { *is_gone = true; }
  };

  /// Null at the end of a thread, where others may outlive what it keeps.
  static Kept* kept() {
    static thread_local bool is_gone = false;
    if (is_gone) return nullptr;
    static thread_local Kept own(&is_gone);
    return &own;
  }

  Buffer buffer_;
};

}  // namespace octavo
