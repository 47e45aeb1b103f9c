// Long work stops where the user asked it to.
#pragma once

#include <cstddef>

#include "octavo/core/error.h"
#include "octavo/core/progress.h"

namespace octavo {

/// Throws  Error{cancelled} once the one who watches asked to stop
inline void stop_if_cancelled(const Progress& watcher) {
  if (watcher.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
}

/// The same, asked now and then of many triangles or points.
inline void stop_now_and_then(std::size_t number, const Progress& watcher) {
  constexpr std::size_t kQuestions = 256;  // one for so many
  if (number % kQuestions == 0) stop_if_cancelled(watcher);
}

}  // namespace octavo
