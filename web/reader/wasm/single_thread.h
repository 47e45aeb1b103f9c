// Included before every source: the C++ library for WebAssembly has no threads and no mutex.
#pragma once

#include <mutex>

namespace std {

struct mutex {
  void lock() noexcept {}
  void unlock() noexcept {}
  bool try_lock() noexcept { return true; }
};

}  // namespace std
