// How work that falls into equal tasks is run.
#pragma once

#include <cstdint>
#include <functional>

namespace octavo {

/// Runs `task(0)` .. `task(count - 1)`, in any order, and returns when all are done.
using ForEach =
    std::function<void(std::int64_t count, const std::function<void(std::int64_t)>& task)>;

}  // namespace octavo
