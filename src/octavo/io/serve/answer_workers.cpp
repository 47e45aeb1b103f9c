#include "octavo/io/serve/answer_workers.h"

#include <system_error>
#include <utility>

namespace octavo {

namespace {

constexpr int kServerError = 500;

SiteAnswer made_or_failed(const std::function<SiteAnswer()>& make) {
  try {
    return make();
  } catch (...) {
    return error_answer(kServerError);
  }
}

}  // namespace

AnswerWorkers::AnswerWorkers(std::size_t most_threads, std::function<void()> wake)
    : most_threads_(most_threads), wake_(std::move(wake)) {}

AnswerWorkers::~AnswerWorkers() {
  {
    const std::lock_guard guard(lock_);
    ends_ = true;
    tasks_.clear();
  }
  changed_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void AnswerWorkers::begin(AnswerTask task) {
  std::unique_lock guard(lock_);
  tasks_.push_back(std::move(task));
  if (idle_ < tasks_.size() && threads_.size() < most_threads_) {
    try {
      threads_.emplace_back([this] { work(); });
    } catch (const std::system_error&) {
      // Those that there are do it; without any it is done here.
      if (threads_.empty()) {
        const AnswerTask own = std::move(tasks_.back());
        tasks_.pop_back();
        made_.push_back({own.client, made_or_failed(own.make)});
        guard.unlock();
        wake_();
        return;
      }
    }
  }
  guard.unlock();
  changed_.notify_one();
}

std::vector<MadeAnswer> AnswerWorkers::take_made() {
  const std::lock_guard guard(lock_);
  return std::exchange(made_, {});
}

void AnswerWorkers::work() {
  std::unique_lock guard(lock_);
  for (;;) {
    ++idle_;
    changed_.wait(guard, [&] { return ends_ || !tasks_.empty(); });
    --idle_;
    if (ends_) return;
    const AnswerTask task = std::move(tasks_.front());
    tasks_.pop_front();
    guard.unlock();
    SiteAnswer answer = made_or_failed(task.make);
    guard.lock();
    made_.push_back({task.client, std::move(answer)});
    guard.unlock();
    wake_();
    guard.lock();
  }
}

}  // namespace octavo
