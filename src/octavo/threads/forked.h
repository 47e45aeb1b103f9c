// Whether a process has the threads that loops run on.
#pragma once

namespace octavo {

/// False in a process that was forked from one that had asked this: its threads stayed behind, and
/// with them locks that nobody opens again. Loops run on the calling thread there.
/// Constant time; safe on many threads at once.
bool has_threads();

}  // namespace octavo
