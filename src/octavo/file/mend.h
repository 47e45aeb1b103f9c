// Mends a damaged file whose damages are flipped bits.
#pragma once

#include <string>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/storage.h"
#include "octavo/file/verify.h"

namespace octavo {

struct MendOptions {
  bool overwrite = false;  ///< an existing file, and what an interrupted build of it left
  ForEach for_each;  ///< as in VerifyOptions
};

struct MendResult {
  std::vector<BitFlip> flips;  ///< turned back; `byte` is an offset in the file
  std::uint64_t file_bytes = 0;
};

/// Copies `input` to `output` with every bit turned back that alone explains a wrong checksum, and
/// proves the copy before it takes its name: a mended file is the one that was written.
/// Returns  no flips, and writes nothing, when the file is sound
/// Throws   Error{corrupt} when some damage is more than one flipped bit, or the file was still
///          growing; Error{not_octavo}, Error{truncated}, Error{io}, Error{cancelled}; nothing is
///          left then
MendResult mend_file(Storage& storage, const std::string& input, const std::string& output,
                     const MendOptions& options, Progress& progress);

}  // namespace octavo
