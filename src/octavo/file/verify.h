// Proves a whole file: every checksum, every brick decoded, every promise of the index kept, and
// every tier made of the one below.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/core/hasher.h"
#include "octavo/file/damage.h"
#include "octavo/file/for_each.h"
#include "octavo/file/reader.h"

namespace octavo {

struct VerifyOptions {
  bool decode = true;   ///< decode every brick; compare what the index, digests and tiers say of it
  ForEach for_each;     ///< how to run the bricks of a layer; empty: one after another
  std::size_t max_listed = 1000;  ///< damages that are described; the others are counted
  MakeHasher make_hasher;         ///< empty: the portable one
};

struct VerifyReport {
  std::int64_t brick_count = 0;          ///< in all tiers
  std::int64_t damaged_brick_count = 0;
  /// Whole themselves, but listed in a damaged index page or coded with a damaged model.
  std::int64_t unreachable_brick_count = 0;
  std::int64_t piece_count = 0;          ///< of bricks, that hold bytes
  std::int64_t damage_count = 0;         ///< all damages
  std::int64_t repairable_count = 0;     ///< those that repair turns back
  std::uint64_t file_bytes = 0;
  std::vector<Damage> damages;           ///< the first max_listed found
  bool is_sound() const { return damage_count == 0; }
};

/// Checks all of `source`. A file whose header, trailer or index root is damaged, or whose metadata
/// do not match their checksum, cannot be looked into: then it throws what FileReader::open throws.
/// Throws  also Error{io} when reading fails, Error{cancelled}
/// Memory  that of the index, one brick per thread and a row of bricks, 64 MiB of it
/// Time    reads the file twice, and bricks of higher tiers once more for each layer below them;
///         where a row of bricks takes more than 64 MiB, those of tier 0 once for each such share
VerifyReport verify_file(std::shared_ptr<const ByteSource> source, const VerifyOptions& options,
                         Progress& progress);

}  // namespace octavo
