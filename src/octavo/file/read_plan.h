// What has to be fetched before something can be read.
//
// Bytes of a file tell where others stand: the header where the index is, the root where its pages
// are, pages where the pieces of bricks are, models and level 1 of a brick which parts it has. A
// plan names all that is known to be missing. Whoever has brought that asks again, until nothing is
// missing: at most four times for a box.
#pragma once

#include <cstdint>
#include <vector>

#include "octavo/file/storage/byte_range.h"

namespace octavo {

class ByteSource;
struct ReaderOptions;

struct ReadPlan {
  /// Rising and apart from one another; empty when nothing is missing.
  std::vector<ByteRange> ranges;
  /// Those of their bytes that are needed; the others lie in the gaps between.
  std::uint64_t needed_bytes = 0;
  /// Whether nothing is missing once these ranges are there. If not, the next plan says what is.
  bool is_complete = true;
};

/// What is missing to open a file, with those bytes that come along.
/// Throws what FileReader::open throws for the bytes that are there
ReadPlan plan_of_opening(const ByteSource& source, const ReaderOptions& options);

}  // namespace octavo
