#include "octavo/builder/workers.h"

#include <utility>

namespace octavo {

Workers::~Workers() {
  // This thread runs what is left. An arena keeps it until a thread comes, which may be never.
  arena_.execute([this] { comings_.wait(); });
}

void Workers::start(std::function<void()> work) {
  const std::lock_guard lock(waiting_->mutex);
  waiting_->works.push_back(std::move(work));
  try {
    arena_.enqueue(comings_.defer([waiting = waiting_] { run_oldest(*waiting); }));
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
