// Work that is started now and waited for later.
#pragma once

#include <functional>
#include <memory>

namespace octavo {

/// Runs on the threads of the arena that starts it; in a forked process (see forked.h), where it is
/// waited for. It must be waited for before this goes.
class StartedWork {
 public:
  StartedWork();
  ~StartedWork();
  StartedWork(const StartedWork&) = delete;
  StartedWork& operator=(const StartedWork&) = delete;

  /// Once.
  void start(std::function<void()> work);
  /// Helps with it. Throws what it threw.
  void wait();
  /// Leaves it out where it has not begun.
  void cancel();

 private:
  struct Threads;
  std::unique_ptr<Threads> threads_;  // null in a forked process
  std::function<void()> waiting_;     // used there
};

}  // namespace octavo
