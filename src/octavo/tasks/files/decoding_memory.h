// What reading .8vo files takes of the memory limit, besides what is read.
#pragma once

#include <cstdint>

#include "octavo/core/volume.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// What a reader keeps of decoded bricks, at most. Where memory is limited, it and what threads
/// decode in take half of it; the cache takes a quarter at least.
std::uint64_t cache_bytes(const TaskContext& context);

/// What is taken beside caches and results while the threads of `context` decode bricks of a
/// volume, or of several of one type: by the program, and by each thread.
std::uint64_t decoding_bytes(const VolumeDescription& volume, const TaskContext& context);

}  // namespace octavo
