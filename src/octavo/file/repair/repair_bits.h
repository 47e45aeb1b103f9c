// Repairs a damaged file whose damages are flipped bits, a damaged trailer or bytes behind its end.
//
// Damage of more bits can pass for one flipped bit: of random damage to n bits a part of n / 2^32
// does, and then every checksum over it would match again with wrong bytes under it. So a bit is
// turned back only where that is unlikely enough for what else proves the bytes (bit_flip.h):
//
//   voxels as they are stored, the header       up to 2^12 bits, odds of 2^-20
//   coded segments, models, index pages,        up to 2^20 bits, odds of 2^-12 times those that
//   thumbnail, directory, metadata              they decode, parse or read as text all the same
//   index root, slab trailers, trailer          any length: all their numbers are proven again
//   other parts                                 none: nothing else proves them
//
// Larger ones are rejected as damage of more bits is. Only a trailer may be damaged as it will: all
// that stands in it is made of the rest.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "octavo/core/progress.h"
#include "octavo/file/bit_flip.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/verify.h"

namespace octavo {

struct BitRepairOptions {
  bool overwrite = false;  ///< an existing file, and what an interrupted build of it left
  ForEach for_each;        ///< as in VerifyOptions
  MakeHasher make_hasher;  ///< as in VerifyOptions
};

struct BitRepairResult {
  std::vector<BitFlip> flips;    ///< turned back, in their order; `byte` is an offset in the file
  bool has_new_trailer = false;  ///< made of all other bytes
  std::uint64_t dropped_bytes = 0;  ///< that stood behind the end of the file
  std::uint64_t file_bytes = 0;     ///< of the output
  bool is_sound() const { return flips.empty() && !has_new_trailer && dropped_bytes == 0; }
};

/// Whether a file that cannot be opened can be once its length, header, trailer, metadata and index
/// root are repaired as repair_bits would.
/// Throws Error{io} when reading fails
bool opens_repaired(const std::shared_ptr<const ByteSource>& source);

/// Copies `input` to `output` with every bit turned back that alone explains a wrong checksum, also
/// where others hide it, with the trailer that belongs to the other bytes and without bytes behind
/// its end, and proves the copy before it takes its name.
/// Returns  BitRepairResult::is_sound, and writes nothing, for a sound file
/// Throws   Error{corrupt} when some damage is not Damage::is_repairable, or the file was still
///          growing; Error{not_octavo}, Error{truncated}, Error{io}, Error{cancelled}, which name
///          `input` or `output`; nothing is left then, but for a file replaced whose name could not
///          be made durable
/// Time     a verification for each round that finds damage, at least two, and one of the copy
BitRepairResult repair_bits(Storage& storage, const std::string& input, const std::string& output,
                            const BitRepairOptions& options, Progress& progress);

}  // namespace octavo
