// The threads of a build.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <cstddef>

namespace octavo {

/// A number of threads that parallel work is confined to, the calling thread among them. The number
/// may exceed the cores of the machine.
class Workers {
 public:
  explicit Workers(int threads)
      : limit_(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads)),
        arena_(threads),
        threads_(threads) {}

  int count() const { return threads_; }

  /// Runs `work`; what it runs in parallel uses these threads. Passes on what it returns and
  /// throws.
  template <class F>
  auto run(F&& work) {
    return arena_.execute(work);
  }

 private:
  tbb::global_control limit_;
  tbb::task_arena arena_;
  int threads_;
};

}  // namespace octavo
