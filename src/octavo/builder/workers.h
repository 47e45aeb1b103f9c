// The threads of a build.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <type_traits>
#include <utility>

namespace octavo {

/// A number of threads that parallel work is confined to; a thread that waits in `run` or `wait`
/// lends its place to one of them. The number may exceed the cores of the machine. In a forked
/// process (see threads/forked.h) it is 1: threads that wait are all there is.
class Workers {
 public:
  /// of_all  the threads of all that work side by side in this process, where there are others
  explicit Workers(int threads, int of_all = 0);

  /// Drops what threads have not come for yet, of which other threads have done the work.
  ~Workers();

  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  int count() const { return count_; }

  /// Runs `work`; what it runs in parallel uses these threads. Passes on what it returns and
  /// throws.
  template <class F>
  auto run(F&& work) {
    using Result = decltype(work());
    if constexpr (std::is_void_v<Result>) {
      run_on_threads([&] { work(); });
    } else {
      std::optional<Result> result;
      run_on_threads([&] { result.emplace(work()); });
      return std::move(*result);
    }
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
    const auto patience = threads_ ? kPatience : kPatience.zero();
    while (!changed.wait_for(lock, patience, is_there)) {
      lock.unlock();
      const bool has_helped = help();
      lock.lock();
      if (!threads_ && !has_helped) changed.wait_for(lock, kPatience, is_there);
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
  void run_on_threads(const std::function<void()>& work);

  struct Threads;
  std::unique_ptr<Threads> threads_;  // null in a forked process
  int count_;
  std::shared_ptr<Waiting> waiting_ = std::make_shared<Waiting>();
};

}  // namespace octavo
