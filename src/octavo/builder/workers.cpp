#include "octavo/builder/workers.h"

#include <utility>

namespace octavo {

void Workers::start(std::function<void()> work) {
  const std::lock_guard lock(waiting_->mutex);
  waiting_->works.push_back(std::move(work));
  try {
    arena_.enqueue([waiting = waiting_] { run_oldest(*waiting); });
  } catch (...) {
    waiting_->works.pop_back();
    throw;
  }
}

bool Workers::run_oldest(Waiting& waiting) {
  std::function<void()> work;
  {
    const std::lock_guard lock(waiting.mutex);
    if (waiting.works.empty()) return false;
    work = std::move(waiting.works.front());
    waiting.works.pop_front();
  }
  work();
  return true;
}

}  // namespace octavo
