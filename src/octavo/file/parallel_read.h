// Reading with many threads.
#pragma once

#include "octavo/file/reader.h"
#include "octavo/file/verify.h"

namespace octavo {

/// What FileReader::read does, brick by brick on `threads` threads (0: all cores); of few bricks
/// those parts that decode alone. The result does not depend on the number of threads.
void read_parallel(const FileReader& reader, const Box& box, int level, void* out, int threads);

/// A way to run tasks on `threads` threads (0: all cores).
ForEach for_each_parallel(int threads);

}  // namespace octavo
