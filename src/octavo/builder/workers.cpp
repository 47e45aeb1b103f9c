#include "octavo/builder/workers.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>
#include <utility>

#include "octavo/threads/forked.h"

namespace octavo {

struct Workers::Threads {
  Threads(int threads, int of_all)
      : limit(tbb::global_control::max_allowed_parallelism,
              static_cast<std::size_t>(std::max(threads, of_all)) + 1),
        arena(threads, 0) {}

  tbb::global_control limit;
  tbb::task_arena arena;
  tbb::task_group comings;  // a task for each work, of a thread that comes for the oldest
};

Workers::Workers(int threads, int of_all)
    : threads_(has_threads() ? std::make_unique<Threads>(threads, of_all) : nullptr),
      count_(threads_ ? threads : 1) {}

Workers::~Workers() {
  // This thread runs what is left. An arena keeps it until a thread comes, which may be never.
  if (threads_) threads_->arena.execute([this] { threads_->comings.wait(); });
}

void Workers::start(std::function<void()> work) {
  const std::lock_guard lock(waiting_->mutex);
  waiting_->works.push_back(std::move(work));
  if (!threads_) return;
  try {
    threads_->arena.enqueue(
        threads_->comings.defer([waiting = waiting_] { run_oldest(*waiting); }));
  } catch (...) {
    waiting_->works.pop_back();
    throw;
  }
}

void Workers::run_on_threads(const std::function<void()>& work) {
  if (threads_) threads_->arena.execute(work);
  else work();
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
