// Room for points or triangles that are appended many at a time, without a look at each.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <utility>
#include <vector>

namespace octavo {

/// Room for some items more behind those that are there. What is never written takes no memory, so
/// that there is much at once: to grow takes longer than to extract what comes.
template <class T>
void make_room(std::vector<T>& items, std::size_t more) {
  constexpr std::size_t kGrowth = 4;
  const std::size_t count = items.size() + more;
  if (count > items.capacity()) items.reserve(std::max(count, kGrowth * items.capacity()));
}

template <class T>
class MeshRoom {
 public:
  void clear() { count_ = 0; }
  std::span<const T> all() const { return {room_.get(), count_}; }
  /// Room for `count` more, unset, behind those that are there.
  T* next(std::size_t count) {
    if (count_ + count > capacity_) grow(count);
    return room_.get() + count_;
  }
  /// Takes what was written up to `end` to those that are there.
  void finish(const T* end) { count_ = static_cast<std::size_t>(end - room_.get()); }

 private:
  void grow(std::size_t count) {
    const std::size_t capacity = 2 * capacity_ + count;
    auto room = std::make_unique_for_overwrite<T[]>(capacity);
    std::copy_n(room_.get(), count_, room.get());
    room_ = std::move(room);
    capacity_ = capacity;
  }

  std::unique_ptr<T[]> room_;
  std::size_t capacity_ = 0;
  std::size_t count_ = 0;
};

}  // namespace octavo
