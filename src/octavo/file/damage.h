// A damaged place of a file: where it is, what is wrong there, and which flipped bit would explain
// it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/box.h"
#include "octavo/core/error.h"
#include "octavo/file/bit_flip.h"

namespace octavo {

struct Damage {
  std::string what;  ///< "brick", "model", "index page", "index pages", "slab trailer",
                     ///< "part 'thmb'", "metadata", "plane", "file"
  int tier = 0;                     ///< of a brick
  int level = 0;                    ///< global level of a brick's piece
  Index3 brick;
  std::uint64_t code = 0;           ///< o-code of a brick, number of anything else
  std::uint64_t offset = 0;
  std::uint64_t length = 0;
  std::optional<std::uint32_t> stored;        ///< checksums, when they differ
  std::optional<std::uint32_t> found;
  std::optional<std::uint64_t>
      flipped_byte;  ///< offset in the file, when one flipped bit explains it
  int flipped_bit = 0;
  OtherProof proof = OtherProof::none;  ///< of its bytes
  std::string detail;               ///< one line for people: the place, then what is wrong

  /// Whether repair turns it back: one flipped bit explains it, and other damage hardly would.
  bool is_repairable() const { return flipped_byte && is_safe_guess(length, proof); }
};

/// `place` with what is wrong there; parsers name the place themselves, which is said once.
Damage damaged(Damage place, const std::string& problem);

/// The damage that two checksums show when they differ, and what one flipped bit would explain.
std::optional<Damage> checksum_damage(Damage place, std::uint32_t found, std::uint32_t stored,
                                      const CheckedBytes& checked);
/// The same where the checksum is that of the place.
std::optional<Damage> checksum_damage(const Damage& place, std::uint32_t found,
                                      std::uint32_t stored);

/// Passes on what is no damage: a disk that fails, a file of a later version.
void require_damage(const Error& error);

}  // namespace octavo
