// What a part of a verification found, and the report of all parts together.
//
// A part proves a run of the layers of every tier. It reads the bytes from the start of its slabs
// to the start of those of the next part; the last one reads on to the trailer. What no part knows
// alone - the checksum of the file - follows from theirs.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "octavo/core/hasher.h"
#include "octavo/core/work_part.h"
#include "octavo/file/damage.h"

namespace octavo {

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

/// Which file a part is of, by what its header and trailer say.
struct VerifiedFile {
  std::uint64_t build_id = 0;
  std::uint64_t bytes = 0;
  std::uint32_t crc = 0;  ///< of all between header and trailer
  Sha256Digest voxel_digest{};

  friend bool operator==(const VerifiedFile&, const VerifiedFile&) = default;
};

struct VerifiedPart {
  WorkPart part;
  VerifiedFile file;
  bool is_decoded = true;  ///< VerifyOptions::decode
  /// Of this part alone, its bricks and pieces.
  VerifyReport report;
  std::vector<int> steps;  ///< of verification that found report.damages, in whose order they stand

  std::uint64_t bytes_read = 0;
  std::uint32_t crc = 0;  ///< of these

  // Damages where nothing else is damaged, in any part
  std::optional<Damage> lying_slab_trailer;
  std::optional<Damage> pages;         ///< known to the last part
  std::optional<Damage> voxel_digest;  ///< known to the last part
  std::optional<Damage> thumbnail;     ///< known to the last part
};

/// The report of all parts, in any order: that of one verification of the whole file.
/// max_listed  as in VerifyOptions
/// Throws Error{invalid_argument} where parts are missing, there twice, of other files or of other
///        verifications
VerifyReport joined_report(std::span<const VerifiedPart> parts, std::size_t max_listed);

}  // namespace octavo
