// Proves a whole file: every checksum, every brick decoded, every promise of the index kept, and
// every tier made of the one below.
#pragma once

#include <cstddef>
#include <memory>

#include "octavo/core/hasher.h"
#include "octavo/core/progress.h"
#include "octavo/core/work_part.h"
#include "octavo/file/for_each.h"
#include "octavo/file/reader.h"
#include "octavo/file/verified_part.h"

namespace octavo {

struct VerifyOptions {
  bool decode = true;   ///< decode every brick; compare what the index, digests and tiers say of it
  ForEach for_each{};   ///< how to run the bricks of a layer; empty: one after another
  std::size_t max_listed = 1000;  ///< damages that are described; the others are counted
  MakeHasher make_hasher{};       ///< empty: the portable one
};

/// Checks all of `source`. A file whose header, trailer or index root is damaged, or whose metadata
/// do not match their checksum, cannot be looked into: then it throws what FileReader::open throws.
/// Where damage is found in bytes that can be asked for anew, they all are, and what is found then
/// counts.
/// Throws  also Error{io} when reading fails, Error{cancelled}
/// Memory  that of the index, one brick per thread and a row of bricks, 64 MiB of it
/// Time    reads the file twice, and bricks of higher tiers once more for each layer below them;
///         where a row of bricks takes more than 64 MiB, those of tier 0 once for each such share;
///         all of that once more where bytes are asked for anew
VerifyReport verify_file(std::shared_ptr<const ByteSource> source, const VerifyOptions& options,
                         Progress& progress);

/// Checks what belongs to one part of the work; joined_report makes the report of all parts.
/// Throws  as verify_file; Error{invalid_argument} for a part that cannot be
/// Time    a share of that of verify_file; every part proves all models
VerifiedPart verify_part(std::shared_ptr<const ByteSource> source, const WorkPart& part,
                         const VerifyOptions& options, Progress& progress);

}  // namespace octavo
