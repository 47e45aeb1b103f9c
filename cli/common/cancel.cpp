#include "common/cancel.h"

#include <unistd.h>

#include <atomic>
#include <csignal>

namespace octavo::cli {

namespace {

std::atomic<int> requested_signal{0};
std::atomic<int> works_running{0};
static_assert(std::atomic<int>::is_always_lock_free, "used inside a signal handler");

extern "C" void on_signal(int signal) {
  int none = 0;
  const bool is_first = requested_signal.compare_exchange_strong(none, signal);
  if (works_running.load() == 0 || !is_first) _exit(128 + signal);
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action = {};
  action.sa_handler = on_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  // Under nohup a terminal that closes ends nothing.
  struct sigaction hangup = {};
  sigaction(SIGHUP, nullptr, &hangup);
  if (hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

bool is_cancel_requested() noexcept { return requested_signal.load() != 0; }

int cancelling_signal() noexcept {
  const int signal = requested_signal.load();
  return signal == 0 ? SIGINT : signal;
}

CancellableWork::CancellableWork() { works_running.fetch_add(1); }
CancellableWork::~CancellableWork() { works_running.fetch_sub(1); }

}  // namespace octavo::cli
