// Threads for answers that take time to make, while the thread of a server goes on with others.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

#include "octavo/io/serve/site_answer.h"

namespace octavo {

/// An answer that is to be made, and one that is.
struct AnswerTask {
  std::uint64_t client = 0;
  std::function<SiteAnswer()> make;
};
struct MadeAnswer {
  std::uint64_t client = 0;
  SiteAnswer answer;
};

/// Begins answers in the order in which they come; threads start when they are needed first.
class AnswerWorkers {
 public:
  /// most_threads  1 or more
  /// wake          called on these threads when an answer is made; does not throw
  AnswerWorkers(std::size_t most_threads, std::function<void()> wake);
  /// Waits for answers that are being made, and drops those that have not begun.
  ~AnswerWorkers();
  AnswerWorkers(const AnswerWorkers&) = delete;
  AnswerWorkers& operator=(const AnswerWorkers&) = delete;

  /// What `make` throws becomes an answer of status 500.
  void begin(AnswerTask task);

  /// All that were made since the last call.
  std::vector<MadeAnswer> take_made();

 private:
  void work();

  const std::size_t most_threads_;
  const std::function<void()> wake_;
  std::mutex lock_;  // of all below
  std::condition_variable changed_;
  std::deque<AnswerTask> tasks_;
  std::vector<MadeAnswer> made_;
  std::vector<std::thread> threads_;
  std::size_t idle_ = 0;
  bool ends_ = false;
};

}  // namespace octavo
