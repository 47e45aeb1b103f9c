// Ranks that are threads of one process: what tests run in place of many machines.
#pragma once

#include <functional>

#include "octavo/dist/communicator.h"

namespace octavo {

/// Runs `work` on `count` threads, each a rank, and waits for all of them. Where one throws, those
/// that wait for others get Error{cancelled}; the first failure is thrown on.
void run_thread_ranks(int count, const std::function<void(Communicator&)>& work);

}  // namespace octavo
