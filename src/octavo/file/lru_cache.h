// A bounded set of shared values; the one not used for the longest time goes first.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <utility>

namespace octavo {

/// Thread-safe. A value that was handed out lives on after it has left the cache.
template <class Value>
class LruCache {
 public:
  using Key = std::pair<std::uint64_t, std::uint64_t>;
  using Pointer = std::shared_ptr<const Value>;

  /// `capacity` is the sum of the weights of the values kept, at most.
  explicit LruCache(std::uint64_t capacity) : capacity_(capacity) {}

  std::uint64_t capacity() const { return capacity_; }

  /// The value of `key`, or nothing.
  Pointer find(const Key& key) {
    const std::lock_guard lock(mutex_);
    const auto found = places_.find(key);
    if (found == places_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->value;
  }

  /// Keeps `value`; one that is heavier than the capacity is not kept. Of two values with one key
  /// the heavier one is, or the first.
  void insert(const Key& key, Pointer value, std::uint64_t weight) {
    const std::lock_guard lock(mutex_);
    if (weight > capacity_) return;
    if (const auto found = places_.find(key); found != places_.end()) {
      if (found->second->weight >= weight) return;
      weight_ -= found->second->weight;
      entries_.erase(found->second);
      places_.erase(found);
    }
    entries_.push_front({key, std::move(value), weight});
    places_[key] = entries_.begin();
    weight_ += weight;
    while (weight_ > capacity_) {
      weight_ -= entries_.back().weight;
      places_.erase(entries_.back().key);
      entries_.pop_back();
    }
  }

 private:
  struct Entry {
    Key key;
    Pointer value;
    std::uint64_t weight;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const noexcept {
      return static_cast<std::size_t>((key.first * 0x9e3779b97f4a7c15u ^ key.second) *
                                      0xff51afd7ed558ccdu >> 7);
    }
  };

  std::mutex mutex_;
  std::uint64_t capacity_;
  std::uint64_t weight_ = 0;
  std::list<Entry> entries_;
  std::unordered_map<Key, typename std::list<Entry>::iterator, Hash> places_;
};

}  // namespace octavo
