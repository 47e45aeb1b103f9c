// Threads that are made for some work and end with it: those of a task arena may wait for it.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <system_error>
#include <thread>
#include <vector>

namespace octavo {

/// Calls work(0) .. work(count - 1) on so many threads, of which the caller is one: each takes the
/// next number until none is left, or one has failed. Where the system gives no more threads, those
/// that there are take more numbers each.
/// Throws  what work threw, of the lowest number that failed
template <class Work>
void on_own_threads(std::size_t count, std::size_t threads, const Work& work) {
  std::atomic<std::size_t> next = 0;
  std::atomic<bool> has_failed = false;
  std::vector<std::exception_ptr> failures(count);
  const auto run = [&] {
    for (std::size_t i = next++; i < count && !has_failed; i = next++) {
      try {
        work(i);
      } catch (...) {
        failures[i] = std::current_exception();
        has_failed = true;
      }
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::size_t i = 1; i < std::min(threads, count); ++i) {
      try {
        others.emplace_back(run);
      } catch (const std::system_error&) {
        break;
      }
    }
    run();
  }
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

}  // namespace octavo
