#include "octavo/threads/forked.h"

#include <pthread.h>

#include <atomic>

namespace octavo {

namespace {

std::atomic<bool> is_forked = false;

void note_fork() { is_forked.store(true, std::memory_order_relaxed); }

}  // namespace

bool has_threads() {
  [[maybe_unused]] static const int failed = pthread_atfork(nullptr, nullptr, note_fork);
  return !is_forked.load(std::memory_order_relaxed);
}

}  // namespace octavo
