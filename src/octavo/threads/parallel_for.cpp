#include "octavo/threads/parallel_for.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <exception>

#include "octavo/threads/forked.h"

namespace octavo {

void run_parts(std::int64_t begin, std::int64_t end, std::int64_t at_least, LoopWork work) {
  if (begin >= end) return;
  if (!has_threads()) return work(begin, end);
  tbb::parallel_for(
      tbb::blocked_range<std::int64_t>(begin, end, static_cast<std::size_t>(at_least)),
      [work](const tbb::blocked_range<std::int64_t>& part) { work(part.begin(), part.end()); });
}

namespace {

/// What run_each does on the calling thread.
void run_in_order(std::int64_t count, LoopWork work) {
  std::exception_ptr failure;
  for (std::int64_t i = 0; i < count; ++i) {
    try {
      work(i, i + 1);
    } catch (...) {
      if (!failure) failure = std::current_exception();
    }
  }
  if (failure) std::rethrow_exception(failure);
}

}  // namespace

void run_each(std::int64_t count, LoopWork work) {
  if (!has_threads()) return run_in_order(count, work);
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::parallel_for(std::int64_t{0}, count, [work](std::int64_t i) { work(i, i + 1); },
                    tbb::simple_partitioner(), own);
}

}  // namespace octavo
