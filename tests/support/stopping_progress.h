// A watcher that asks to stop.
#pragma once

#include <atomic>
#include <cstdint>
#include <string_view>

#include "octavo/core/progress.h"

namespace octavo::testing {

/// Asks to stop from the question after `answered` others on; counts what is reported to it.
class StoppingProgress final : public Progress {
 public:
  explicit StoppingProgress(int answered = 0) : answered_(answered) {}
  void begin(std::string_view, std::int64_t total, std::string_view) override { total_ += total; }
  void advance(std::int64_t units) override { done_ += units; }
  void end() override { ++ends_; }
  bool is_cancelled() const override { return questions_++ >= answered_; }

  int answered_;
  std::int64_t total_ = 0;
  std::atomic<std::int64_t> done_ = 0;
  int ends_ = 0;
  mutable std::atomic<int> questions_ = 0;
};

}  // namespace octavo::testing
