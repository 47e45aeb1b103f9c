#include "octavo/threads/parallel_for.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

namespace octavo {

void run_parts(std::int64_t begin, std::int64_t end, std::int64_t at_least, LoopWork work) {
  if (begin >= end) return;
  tbb::parallel_for(
      tbb::blocked_range<std::int64_t>(begin, end, static_cast<std::size_t>(at_least)),
      [work](const tbb::blocked_range<std::int64_t>& part) { work(part.begin(), part.end()); });
}

void run_each(std::int64_t count, LoopWork work) {
  tbb::task_group_context own(tbb::task_group_context::isolated);
  tbb::parallel_for(std::int64_t{0}, count, [work](std::int64_t i) { work(i, i + 1); },
                    tbb::simple_partitioner(), own);
}

}  // namespace octavo
