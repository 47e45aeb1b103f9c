#include "call.h"

#include <nanobind/stl/string.h>

#include <algorithm>
#include <condition_variable>

#include "octavo/core/error.h"

namespace octavo::python {

namespace nb = nanobind;

namespace {

thread_local const Call* this_threads_call = nullptr;

/// Between two looks for signals, and between two reports of progress.
constexpr std::chrono::milliseconds kPause{50};
constexpr std::chrono::milliseconds kReportPause{100};

}  // namespace

const Call* current_call() noexcept { return this_threads_call; }

call_detail::Current::Current(const Call* call) : before_(this_threads_call) {
  this_threads_call = call;
}

call_detail::Current::~Current() { this_threads_call = before_; }

void Waiters::add(const Call& call) {
  const std::lock_guard guard(lock_);
  calls_.push_back(&call);
}

void Waiters::remove(const Call& call) {
  const std::lock_guard guard(lock_);
  calls_.erase(std::ranges::find(calls_, &call));
}

bool Waiters::are_stopped() const {
  if (this_threads_call != nullptr && this_threads_call->is_over()) return true;
  const std::lock_guard guard(lock_);
  return !calls_.empty() &&
         std::ranges::all_of(calls_, [](const Call* call) { return call->is_over(); });
}

Call::Call(nb::object on_progress)
    : on_progress_(std::move(on_progress)), around_(this_threads_call) {}

Call::~Call() = default;

void Call::keep_failure() const noexcept {
  const std::lock_guard guard(lock_);
  if (!failure_) failure_ = std::current_exception();
  is_cancelled_ = true;
}

void Call::throw_kept() {
  const std::lock_guard guard(lock_);
  if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
}

void Call::throw_cancelled() { throw Error(ErrorKind::cancelled, "stopped"); }

bool Call::is_over() const noexcept {
  return is_cancelled_ || (around_ != nullptr && around_->is_over());
}

bool Call::is_cancelled() const {
  if (is_over()) return true;
  if (std::this_thread::get_id() != owner_) return false;
  const Clock::time_point now = Clock::now();
  if (now - polled_ < kPause) return false;
  polled_ = now;
  const nb::gil_scoped_acquire acquire;
  if (PyErr_CheckSignals() == 0) return false;
  try {
    throw nb::python_error();
  } catch (...) {
    keep_failure();
  }
  return true;
}

void Call::run_apart(const std::function<void()>& work) {
  run([&] {
    std::exception_ptr thrown;
    std::atomic<bool> is_over{false};
    std::mutex lock;
    std::condition_variable ended;
    std::thread apart([&] {
      const call_detail::Current current(this);
      try {
        work();
      } catch (...) {
        thrown = std::current_exception();
      }
      const std::lock_guard guard(lock);
      is_over = true;
      ended.notify_all();
    });
    {
      std::unique_lock guard(lock);
      while (!ended.wait_for(guard, kPause, [&] { return is_over.load(); })) {
        guard.unlock();
        is_cancelled();
        guard.lock();
      }
    }
    apart.join();
    if (thrown) std::rethrow_exception(thrown);
  });
  throw_kept();
}

void Call::begin(std::string_view what, std::int64_t total, std::string_view) {
  const std::lock_guard guard(telling_);
  what_ = what;
  done_ = 0;
  total_ = total;
}

void Call::advance(std::int64_t units) {
  if (on_progress_.is_none()) return;
  {
    const std::lock_guard guard(telling_);
    done_ += units;
    const Clock::time_point now = Clock::now();
    if (now - told_ < kReportPause) return;
    told_ = now;
  }
  tell();
}

void Call::end() {
  if (!on_progress_.is_none() && !is_cancelled_) tell();
}

void Call::tell() {
  const call_detail::Current current(this);
  const nb::gil_scoped_acquire acquire;
  std::int64_t done;
  std::int64_t total;
  std::string what;
  {
    const std::lock_guard guard(telling_);
    done = done_;
    total = total_;
    what = what_;
  }
  try {
    on_progress_(done, total, what);
  } catch (...) {
    keep_failure();
  }
}

}  // namespace octavo::python
