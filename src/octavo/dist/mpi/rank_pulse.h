// What shows the other ranks of a job that this one works.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <string_view>

#include "octavo/core/progress.h"
#include "octavo/dist/communicator.h"

namespace octavo {

/// What a rank tells of itself, from any thread.
struct RankPulse {
  std::atomic<std::uint64_t> steps = 0;  ///< grows while the rank works
  std::atomic<bool> is_at_work = false;  ///< whether it should
};

/// Passes progress on, and shows the other ranks that this one works.
class WatchedProgress final : public Progress {
 public:
  WatchedProgress(Progress& shown, RankPulse& pulse) : shown_(shown), pulse_(pulse) {}
  void begin(std::string_view what, std::int64_t total, std::string_view unit) override {
    ++pulse_.steps;
    pulse_.is_at_work = true;
    shown_.begin(what, total, unit);
  }
  void advance(std::int64_t units) override {
    ++pulse_.steps;
    shown_.advance(units);
  }
  void end() override {
    pulse_.is_at_work = false;
    shown_.end();
  }
  bool is_cancelled() const override {
    ++pulse_.steps;
    return shown_.is_cancelled();
  }

 private:
  Progress& shown_;
  RankPulse& pulse_;
};

/// Counts waiting for others as a step of the rank that waits.
class SteppingRanks final : public Communicator {
 public:
  SteppingRanks(Communicator& ranks, RankPulse& pulse) : ranks_(ranks), pulse_(pulse) {}
  int rank() const override { return ranks_.rank(); }
  int size() const override { return ranks_.size(); }
  void send(int to, ByteSpan bytes) override {
    const Rest rest(pulse_);
    ranks_.send(to, bytes);
  }
  Bytes receive(int from) override {
    const Rest rest(pulse_);
    return ranks_.receive(from);
  }
  RankSums sum_before(std::span<const std::uint64_t> values) override {
    const Rest rest(pulse_);
    return ranks_.sum_before(values);
  }
  Bytes broadcast(ByteSpan bytes) override {
    const Rest rest(pulse_);
    return ranks_.broadcast(bytes);
  }
  void barrier() override {
    const Rest rest(pulse_);
    ranks_.barrier();
  }

 private:
  /// No work of its own while it lives.
  class Rest {
   public:
    explicit Rest(RankPulse& pulse) : pulse_(pulse), was_at_work_(pulse.is_at_work) {
      pulse_.is_at_work = false;
    }
    ~Rest() {
      ++pulse_.steps;
      pulse_.is_at_work = was_at_work_;
    }
    Rest(const Rest&) = delete;
    Rest& operator=(const Rest&) = delete;

   private:
    RankPulse& pulse_;
    bool was_at_work_;
  };

  Communicator& ranks_;
  RankPulse& pulse_;
};

}  // namespace octavo
