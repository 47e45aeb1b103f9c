// The threads that loops run on.
//
// A loop runs on the threads of the arena that its caller is in; outside of all, on one per core.
#pragma once

#include <functional>

namespace octavo {

/// Threads of the caller's arena, with its own.
int arena_threads();

/// Runs `work` in an arena of so many threads, at most as many as the process may use; with 0, of
/// all these.
void run_in_arena(int threads, const std::function<void()>& work);

/// Runs `work`; while its loops wait for other threads, the calling one takes up nothing but their
/// turns. For callers that stand in the midst of something another turn might use too.
void run_isolated(const std::function<void()>& work);

}  // namespace octavo
