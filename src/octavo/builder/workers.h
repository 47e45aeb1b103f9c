// The threads of a build.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

namespace octavo {

/// A number of threads that parallel work is confined to; a thread that waits in `run` or `wait`
/// lends its place to one of them. The number may exceed the cores of the machine.
class Workers {
 public:
  /// of_all  the threads of all that work side by side in this process, where there are others
  explicit Workers(int threads, int of_all = 0)
      : limit_(tbb::global_control::max_allowed_parallelism,
               static_cast<std::size_t>(std::max(threads, of_all)) + 1),
        arena_(threads, 0),
        threads_(threads) {}

  /// Drops what threads have not come for yet, of which other threads have done the work.
  ~Workers();

  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return threads_; }

  /// Runs `work`; what it runs in parallel uses these threads. Passes on what it returns and
  /// throws.
  template <class F>
  auto run(F&& work) {
    return arena_.execute(work);
  }

  /// Has one of the threads run `work`, which must not throw, and does not wait for it. Work starts
  /// in the order it was given in, before idle threads help with what runs in parallel. Throws
  /// std::bad_alloc; `work` is dropped then.
  void start(std::function<void()> work);

  /// Runs work of start() that no thread has begun, the oldest. False: there is none.
  bool help() { return run_oldest(*waiting_); }

  /// Waits until `is_there()`, which `lock` guards and `changed` announces. Runs what the threads
  /// leave lying meanwhile: those of TBB look for work where there was some, yielding to all other
  /// programs, before they come to another arena. On a busy machine that takes seconds.
  template <class IsThere>
  void wait(std::condition_variable& changed, std::unique_lock<std::mutex>& lock,
            const IsThere& is_there) {
    while (!changed.wait_for(lock, kPatience, is_there)) {
      lock.unlock();
      help();
      lock.lock();
    }
  }

 private:
  static constexpr std::chrono::milliseconds kPatience{5};

  /// Work in its order. A thread may come for it when another one has done it, and this is gone.
  struct Waiting {
    std::mutex mutex;
    std::deque<std::function<void()>> works;
  };

  static bool run_oldest(Waiting& waiting);

  tbb::global_control limit_;
  tbb::task_arena arena_;
  tbb::task_group comings_;  // a task for each work, of a thread that comes for the oldest
  int threads_;
  std::shared_ptr<Waiting> waiting_ = std::make_shared<Waiting>();
};

}  // namespace octavo
