#include "octavo/builder/workers.h"

#include <utility>

namespace octavo {

void Workers::start(std::function<void()> work) {
  waiting_->push(std::move(work));
  arena_.enqueue([waiting = waiting_] { waiting->run_oldest(); });
}

void Workers::Queue::push(std::function<void()> work) {
  const std::lock_guard lock(mutex_);
  works_.push_back(std::move(work));
}

bool Workers::Queue::run_oldest() {
  std::function<void()> work;
  {
    const std::lock_guard lock(mutex_);
    if (works_.empty()) return false;
    work = std::move(works_.front());
    works_.pop_front();
  }
  work();
  return true;
}

}  // namespace octavo
