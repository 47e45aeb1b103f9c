// A verification in parts: each proves its layers of a file and keeps what it found; together they
// say what one verification says.
#pragma once

#include <string>
#include <vector>

#include "octavo/file/verified_part.h"
#include "octavo/tasks/files/verify_volume.h"
#include "octavo/tasks/outputs.h"

namespace octavo {

struct VerifyPartOptions {
  std::string input;  ///< an .8vo file or a URL of one
  WorkPart part;
  Output output;      ///< what the part found
};

/// Verifies one part, and writes what it found, damage as well.
/// Throws  as verify_part and write_part_result; as verify_volume, about the field "input.repair"
VerifiedPart verify_volume_part(const VerifyPartOptions& options, const TaskContext& context);

struct JoinVerifiedOptions {
  std::string input;               ///< the file that was verified
  std::vector<std::string> parts;  ///< what verify_volume_part wrote
};

/// What verify_volume says of the file.
/// Throws  as joined_report, read_part_result and for `input` as open_volume;
///         Error{invalid_argument} for parts of another file, by what it says of itself and by the
///         time at which it was written
VerifyVolumeResult join_verified(const JoinVerifiedOptions& options, const TaskContext& context);

}  // namespace octavo
