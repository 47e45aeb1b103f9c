// The seam between long work and whoever watches it.
#pragma once

#include <cstdint>
#include <string_view>

namespace octavo {

/// Receives the progress of one piece of work; every call may come from any thread.
class Progress {
 public:
  virtual ~Progress() = default;
  /// Announces all the work: `total` units, named for people ("planes", "bricks").
  virtual void begin(std::string_view what, std::int64_t total, std::string_view unit) = 0;
  virtual void advance(std::int64_t units) = 0;
  virtual void end() = 0;
  /// True when the user asked to stop; the work then throws Error{cancelled} at its next step.
  virtual bool is_cancelled() const = 0;
};

/// Announces work, and its end however it comes.
class ProgressScope {
 public:
  ProgressScope(Progress& progress, std::string_view what, std::int64_t total,
                std::string_view unit)
      : progress_(progress) {
    progress_.begin(what, total, unit);
  }
  ~ProgressScope() { progress_.end(); }
  ProgressScope(const ProgressScope&) = delete;
  ProgressScope& operator=(const ProgressScope&) = delete;

 private:
  Progress& progress_;
};

/// Watches nothing, never cancels.
class NoProgress final : public Progress {
 public:
  void begin(std::string_view, std::int64_t, std::string_view) override {}
  void advance(std::int64_t) override {}
  void end() override {}
  bool is_cancelled() const override { return false; }
};

}  // namespace octavo
