// The threads of a build.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>
#include <utility>

namespace octavo {

/// A number of threads that parallel work is confined to; a thread that waits in `run` lends its
/// place to one of them. The number may exceed the cores of the machine.
class Workers {
 public:
  /// of_all  the threads of all that work side by side in this process, where there are others
  explicit Workers(int threads, int of_all = 0)
      : limit_(tbb::global_control::max_allowed_parallelism,
               static_cast<std::size_t>(std::max(threads, of_all)) + 1),
        arena_(threads, 0),
        threads_(threads) {}

  int count() const { return threads_; }

  /// Runs `work`; what it runs in parallel uses these threads. Passes on what it returns and
  /// throws.
  template <class F>
  auto run(F&& work) {
    return arena_.execute(work);
  }

  /// Has one of the threads run `work`, which must not throw, and does not wait for it. Work starts
  /// in the order it was given in, before idle threads help with what runs in parallel.
  template <class F>
  void start(F&& work) {
    arena_.enqueue(std::forward<F>(work));
  }

 private:
  tbb::global_control limit_;
  tbb::task_arena arena_;
  int threads_;
};

}  // namespace octavo
