// One call from Python that works without the GIL: it polls for Ctrl-C, tells progress, and carries
// what Python code raised on the way back to the caller.
#pragma once

#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/progress.h"

namespace octavo::python {

class Call;

/// The calls that wait for the bytes of one file.
class Waiters {
 public:
  void add(const Call& call);
  void remove(const Call& call);
  /// Whether the call of this thread wants the bytes no more, or none of those that wait does.
  bool are_stopped() const;

 private:
  mutable std::mutex lock_;
  std::vector<const Call*> calls_;
};

/// Those of the files that a call reads.
using FilesRead = std::vector<std::shared_ptr<Waiters>>;

class Call final : public Progress {
 public:
  /// Ends with the call of this thread, if there is one.
  /// on_progress  called as (done, total, what), at most ten times a second and at the end, or None
  /// Requires the GIL
  explicit Call(nanobind::object on_progress = nanobind::none());
  ~Call() override;
  Call(const Call&) = delete;
  Call& operator=(const Call&) = delete;

  /// Runs `work` without the GIL. Where Python code raised, or Ctrl-C came, that is what is thrown.
  template <class Work>
  decltype(auto) run(Work&& work);

  /// The same on a thread of its own, while this one looks for Ctrl-C: for work whose first thread
  /// waits for others.
  void run_apart(const std::function<void()>& work);

  /// run(), and run_apart() where servers may let the work wait: whatever thread asks them, Ctrl-C
  /// ends it.
  /// files  null where all is at hand
  template <class Work>
  auto run_reading(FilesRead files, Work&& work);

  void begin(std::string_view what, std::int64_t total, std::string_view unit) override;
  void advance(std::int64_t units) override;
  void end() override;
  /// Ends this call with the exception that is being handled, which run() throws then.
  /// Requires the GIL, and the thread of the call
  void end_with_raised() const noexcept { keep_failure(); }
  /// True from when a signal handler or `on_progress` raised on.
  bool is_cancelled() const override;
  /// The same as far as it is known: runs no handler.
  bool is_over() const noexcept;

  /// Throws what Python code raised, where nothing has thrown it yet: at the very end of the work.
  void throw_kept();

  /// Runs `work`, which calls Python, with the GIL. What it raises ends this call: it is kept for
  /// run() and thrown as Error{cancelled}.
  template <class Work>
  void with_python(Work&& work);

 private:
  using Clock = std::chrono::steady_clock;

  void keep_failure() const noexcept;
  [[noreturn]] static void throw_cancelled();
  void tell();

  nanobind::object on_progress_;
  const Call* const around_;  // the call of whose work this one is a part, or null
  const std::thread::id owner_ = std::this_thread::get_id();
  mutable std::atomic<bool> is_cancelled_{false};
  mutable std::mutex lock_;              // of failure_
  mutable std::exception_ptr failure_;  // what Python raised first
  mutable Clock::time_point polled_ = Clock::now();
  std::mutex telling_;  // of all below
  Clock::time_point told_ = Clock::now();
  std::int64_t done_ = 0;
  std::int64_t total_ = 0;
  std::string what_;
};

/// The call whose thread this is; readers ask it whether to stop. Null on other threads.
const Call* current_call() noexcept;

/// Watches a reader for all calls: each is stopped by its own thread alone.
class CallWatcher final : public Progress {
 public:
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t) override {}
  void end() override {}
  bool is_cancelled() const override {
    const Call* const call = current_call();
    return call != nullptr && call->is_cancelled();
  }
};

// ---- implementation of the templates

namespace call_detail {

/// Makes a call that of this thread while it lives.
class Current {
 public:
  explicit Current(const Call* call);
  ~Current();
  Current(const Current&) = delete;
  Current& operator=(const Current&) = delete;

 private:
  const Call* before_;
};

}  // namespace call_detail

template <class Work>
decltype(auto) Call::run(Work&& work) {
  const call_detail::Current current(this);
  try {
    const nanobind::gil_scoped_release release;
    return std::forward<Work>(work)();
  } catch (...) {
    throw_kept();
    throw;
  }
}

template <class Work>
auto Call::run_reading(FilesRead files, Work&& work) {
  using Result = decltype(work());
  std::erase(files, nullptr);
  if (files.empty()) return run(std::forward<Work>(work));
  for (const auto& file : files) file->add(*this);
  struct Leaving {
    const FilesRead& files;
    const Call& call;
    ~Leaving() {
      for (const auto& file : files) file->remove(call);
    }
  } const leaving{files, *this};
  if constexpr (std::is_void_v<Result>) {
    run_apart([&] { work(); });
  } else {
    std::optional<Result> result;
    run_apart([&] { result.emplace(work()); });
    return std::move(*result);
  }
}

template <class Work>
void Call::with_python(Work&& work) {
  {
    const call_detail::Current current(this);
    const nanobind::gil_scoped_acquire acquire;
    try {
      std::forward<Work>(work)();
      return;
    } catch (...) {
      keep_failure();
    }
  }
  throw_cancelled();
}

}  // namespace octavo::python
