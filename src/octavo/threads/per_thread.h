// A value for each thread that asks for one: room to work in, or what a thread has found.
#pragma once

#include <cstddef>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <utility>

namespace octavo {

/// A pointer for each thread, null where the thread has set none.
class ThreadPointers {
 public:
  ThreadPointers();
  ~ThreadPointers();
  ThreadPointers(const ThreadPointers&) = delete;
  ThreadPointers& operator=(const ThreadPointers&) = delete;

  /// The one of the calling thread. Constant time; safe on many threads at once.
  void*& local();

 private:
  struct Table;
  std::unique_ptr<Table> table_;
};

template <class T>
class PerThread {
 public:
  PerThread() : make_([] { return T(); }) {}
  /// make  gives the value of a thread that asks for the first time; called on many at once
  explicit PerThread(std::function<T()> make) : make_(std::move(make)) {}

  /// The value of the calling thread. Safe on many threads at once.
  T& local() {
    void*& pointer = pointers_.local();
    if (pointer == nullptr) pointer = &add();
    return *static_cast<T*>(pointer);
  }

  /// Threads that asked so far.
  std::size_t size() const { return values_.size(); }

  // The values of all threads that asked, in no order; while no thread asks.
  auto begin() { return values_.begin(); }
  auto end() { return values_.end(); }
  auto begin() const { return values_.begin(); }
  auto end() const { return values_.end(); }

 private:
  // Built in its place, so that a value need not be movable.
  struct Emplaced {
    operator T() const { return make(); }
    const std::function<T()>& make;
  };

  T& add() {
    std::list<T> one;
    one.emplace_back(Emplaced{make_});
    const std::lock_guard lock(mutex_);
    values_.splice(values_.end(), one);
    return values_.back();
  }

  std::function<T()> make_;
  ThreadPointers pointers_;
  std::mutex mutex_;
  std::list<T> values_;
};

}  // namespace octavo
