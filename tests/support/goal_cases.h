// The cases of a goal of docs/reliability.md: few in the everyday run, all of them under
// tools/nightly, which reads the line that the last one leaves.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

namespace octavo::testing {

/// True under tools/nightly, which sets OCTAVO_NIGHTLY_SHARE.
inline bool is_full_form() { return std::getenv("OCTAVO_NIGHTLY_SHARE") != nullptr; }

/// `usual` in the everyday run; under tools/nightly the share of `full` that it asks for, at
/// least `usual`.
inline std::uint64_t case_count(std::uint64_t usual, std::uint64_t full) {
  const char* share = std::getenv("OCTAVO_NIGHTLY_SHARE");
  if (share == nullptr) return usual;
  const double count = static_cast<double>(full) * std::strtod(share, nullptr);
  return count > static_cast<double>(usual) ? static_cast<std::uint64_t>(count) : usual;
}

/// Counts the cases of one loop and prints, when it ends, "goal C1: 10000 of 10000 headers, ...".
/// OCTAVO_NIGHTLY_SECONDS ends the loop early; the line then tells how far it got.
class GoalCases {
 public:
  /// what  the cases, in the plural
  GoalCases(std::string goal, std::string what, std::uint64_t count)
      : goal_(std::move(goal)), what_(std::move(what)), count_(count) {
    const char* seconds = std::getenv("OCTAVO_NIGHTLY_SECONDS");
    if (seconds != nullptr) seconds_ = std::strtod(seconds, nullptr);
  }
  GoalCases(const GoalCases&) = delete;
  GoalCases& operator=(const GoalCases&) = delete;
  ~GoalCases() {
    std::printf("goal %s: %llu of %llu %s%s\n", goal_.c_str(),
                static_cast<unsigned long long>(done_), static_cast<unsigned long long>(count_),
                what_.c_str(), figure_.c_str());
    std::fflush(stdout);
  }

  /// True when one more case is to be run, which then counts as done.
  bool next() {
    if (done_ == count_ || !is_in_time()) return false;
    ++done_;
    return true;
  }

  /// False once OCTAVO_NIGHTLY_SECONDS have passed.
  bool is_in_time() const {
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    return seconds_ <= 0 || spent.count() <= seconds_;
  }

  std::uint64_t done() const { return done_; }

  /// Says that there are no more cases than those that were run.
  void finish() { count_ = done_; }

  /// What the line ends with.
  void tell(const std::string& figure) { figure_ = ", " + figure; }

 private:
  std::string goal_;
  std::string what_;
  std::uint64_t count_;
  std::uint64_t done_ = 0;
  double seconds_ = 0;
  std::string figure_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace octavo::testing
