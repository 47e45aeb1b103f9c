#include "octavo/threads/arena.h"

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

#include "octavo/threads/forked.h"

namespace octavo {

namespace {

using ArenaOfThreads = std::pair<int, std::unique_ptr<tbb::task_arena>>;

/// Arenas that nobody is in. A thread that has nothing to do looks around in the arena it was in
/// for a while, on a loaded machine for long: work in a new one it would not see.
struct IdleArenas {
  static constexpr std::size_t kMost = 16;

  /// Never ends, as threads may still look into arenas when a program does.
  static IdleArenas& shared() {
    static IdleArenas& idle = *new IdleArenas;
    return idle;
  }

  IdleArenas() { arenas.reserve(kMost); }

  std::mutex mutex;
  std::vector<ArenaOfThreads> arenas;
};

/// An arena that one caller has for itself.
class LentArena {
 public:
  explicit LentArena(int threads) : own_(threads, nullptr) {
    IdleArenas& idle = IdleArenas::shared();
    // Nobody waits for another: a new one serves as well.
    if (const std::unique_lock lock(idle.mutex, std::try_to_lock); lock.owns_lock()) {
      for (ArenaOfThreads& arena : idle.arenas) {
        if (arena.first != threads) continue;
        std::swap(arena, idle.arenas.back());
        own_ = std::move(idle.arenas.back());
        idle.arenas.pop_back();
        return;
      }
    }
    own_.second = std::make_unique<tbb::task_arena>(threads);
  }

  ~LentArena() {
    IdleArenas& idle = IdleArenas::shared();
    // Where `work` forked, who held it may be gone.
    const std::unique_lock lock(idle.mutex, std::try_to_lock);
    if (lock.owns_lock() && idle.arenas.size() < IdleArenas::kMost) {
      idle.arenas.push_back(std::move(own_));
    }
  }

  LentArena(const LentArena&) = delete;
  LentArena& operator=(const LentArena&) = delete;

  tbb::task_arena& operator*() const { return *own_.second; }

 private:
  ArenaOfThreads own_;
};

}  // namespace

int arena_threads() { return has_threads() ? tbb::this_task_arena::max_concurrency() : 1; }

void run_in_arena(int threads, const std::function<void()>& work) {
  if (!has_threads()) return work();
  // TBB tells stderr of workers that it cannot give, which is the process's own.
  const auto allowed = static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  const LentArena arena(threads > 0 ? std::min(threads, allowed) : tbb::task_arena::automatic);
  (*arena).execute(work);
}

void run_isolated(const std::function<void()>& work) {
  if (!has_threads()) return work();
  tbb::this_task_arena::isolate(work);
}

}  // namespace octavo
