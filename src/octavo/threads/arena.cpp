#include "octavo/threads/arena.h"

#include <tbb/task_arena.h>

namespace octavo {

int arena_threads() { return tbb::this_task_arena::max_concurrency(); }

void run_in_arena(int threads, const std::function<void()>& work) {
  tbb::task_arena(threads > 0 ? threads : tbb::task_arena::automatic).execute(work);
}

void run_isolated(const std::function<void()>& work) { tbb::this_task_arena::isolate(work); }

}  // namespace octavo
