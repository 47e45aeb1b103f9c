// Proves one brick: the checksums of its pieces, its voxels, and the sample of the next tier that
// it determines.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/file/damage.h"
#include "octavo/file/open_file.h"
#include "octavo/file/plane_digests.h"

namespace octavo {

/// The place of a piece of a brick.
Damage brick_place(const BrickEntry& entry, int piece);

struct CheckedBrick {
  std::vector<Damage> damages;
  /// Its sample at the first level of the next tier, of exact floats its bits; nothing where the
  /// brick is damaged, was not decoded or stands in the last tier.
  std::optional<std::int64_t> parent;
};

/// The parent of a brick of one code.
std::int64_t uniform_parent(const VolumeDescription& volume, std::int64_t code);

struct BrickCheck {
  bool decodes = true;             ///< the model of the brick is whole, too
  PlaneDigests* planes = nullptr;  ///< gets the voxels, where it is not null
};

/// Checks a brick. Throws Error{io}; Error{unsupported_version} where it is of a later version.
CheckedBrick check_brick(const OpenFile& file, const BrickEntry& entry, const BrickCheck& check);

/// The samples of a brick at its finest level as CheckedBrick::parent has them, dense [z][y][x].
/// Throws Error{corrupt}, and as check_brick
std::vector<std::int64_t> parents_in(const OpenFile& file, const BrickEntry& entry);

/// Whether two of these are the same sample to a reader.
bool are_read_alike(const VolumeDescription& volume, std::int64_t a, std::int64_t b);

/// A sample as it is read: "-7", "0.25", "nan".
std::string sample_text(const VolumeDescription& volume, std::int64_t parent);

}  // namespace octavo
