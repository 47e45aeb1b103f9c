#include "octavo/dist/thread_ranks.h"

#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "octavo/core/error.h"

namespace octavo {

namespace {

/// The messages under way, and how the job goes.
class RankMail {
 public:
  explicit RankMail(int count)
      : count_(count), boxes_(static_cast<std::size_t>(count) * static_cast<std::size_t>(count)) {}

  int count() const { return count_; }

  void put(int from, int to, ByteSpan bytes) {
    const std::lock_guard lock(mutex_);
    box(from, to).emplace_back(bytes.begin(), bytes.end());
    changed_.notify_all();
  }

  Bytes take(int from, int to) {
    std::unique_lock lock(mutex_);
    auto& waiting = box(from, to);
    changed_.wait(lock, [&] { return !waiting.empty() || failure_ != nullptr; });
    if (waiting.empty()) {
      throw Error(ErrorKind::cancelled,
                  "rank " + std::to_string(to) + " waited for rank " + std::to_string(from) +
                      ", but the job ends");
    }
    Bytes bytes = std::move(waiting.front());
    waiting.pop_front();
    return bytes;
  }

  void fail(std::exception_ptr failure) {
    const std::lock_guard lock(mutex_);
    if (!failure_) failure_ = std::move(failure);
    changed_.notify_all();
  }

  void rethrow() const {
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  std::deque<Bytes>& box(int from, int to) {
    return boxes_[static_cast<std::size_t>(from * count_ + to)];
  }

  int count_;
  std::mutex mutex_;  // guards what follows
  std::condition_variable changed_;
  std::vector<std::deque<Bytes>> boxes_;  // [from][to]
  std::exception_ptr failure_;
};

class ThreadRank final : public Communicator {
 public:
  ThreadRank(RankMail& mail, int rank) : mail_(mail), rank_(rank) {}
  int rank() const override { return rank_; }
  int size() const override { return mail_.count(); }
  void send(int to, ByteSpan bytes) override { mail_.put(rank_, to, bytes); }
  Bytes receive(int from) override { return mail_.take(from, rank_); }

 private:
  RankMail& mail_;
  int rank_;
};

}  // namespace

void run_thread_ranks(int count, const std::function<void(Communicator&)>& work) {
  RankMail mail(count);
  std::vector<std::thread> threads;
  for (int rank = 0; rank < count; ++rank) {
    threads.emplace_back([&mail, &work, rank] {
      ThreadRank own(mail, rank);
      try {
        work(own);
      } catch (...) {
        mail.fail(std::current_exception());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  mail.rethrow();
}

}  // namespace octavo
