// Progress on standard error: a bar on a terminal, a line per 10 % elsewhere, JSON lines for
// programs.
#pragma once

#include <chrono>
#include <mutex>
#include <string>

#include "common/cancel.h"
#include "common/context.h"
#include "octavo/core/progress.h"

namespace octavo::cli {

/// Watches one piece of work after another. While it lives, SIGINT and SIGTERM ask the work to
/// stop. Every call may come from any thread.
class ProgressLine final : public Progress {
 public:
  explicit ProgressLine(const Context& context);
  ~ProgressLine() override;

  void begin(std::string_view what, std::int64_t total, std::string_view unit) override;
  void advance(std::int64_t units) override;
  void end() override;
  bool is_cancelled() const override { return is_cancel_requested(); }

 private:
  using Clock = std::chrono::steady_clock;

  void show(Clock::time_point now);
  void erase_bar();
  std::string bar_text(double seconds) const;
  std::string plain_text(double seconds) const;
  std::string json_text(double seconds) const;
  bool is_due(Clock::time_point now) const;

  CancellableWork work_;
  ProgressMode mode_;
  std::mutex mutex_;
  std::string what_;
  std::string unit_;
  std::int64_t total_ = 0;
  std::int64_t done_ = 0;
  std::int64_t shown_tenth_ = 0;
  bool is_running_ = false;
  bool is_bar_visible_ = false;
  Clock::time_point start_;
  Clock::time_point shown_;
};

}  // namespace octavo::cli
