// Seals what an interrupted build left, without its source.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"

namespace octavo {

struct SealOptions {
  bool overwrite = false;  ///< an existing file, and what an interrupted build of it left
  int threads = 0;  ///< 0: all cores
};

struct SealResult {
  std::string input;              ///< the growing file that was read
  std::int64_t whole_planes = 0;  ///< from plane 0 on
  std::int64_t plane_count = 0;   ///< of the volume
  double fill = 0;                ///< stored voxel of all other planes
  std::uint64_t file_bytes = 0;
};

/// True for the name that a file has while it grows, and that of its journal.
bool is_growing_name(const std::string& path);

/// Writes `output`, of the size of the whole volume: the planes that an interrupted build finished
/// hold what they would hold, all others the lowest value among them (labels: 0). The metadata say
/// so: "repaired" {"missing_planes": [first, last], "fill"}. What was left stays as it is.
/// input    what was being built, the growing file, or its journal
/// Returns  nothing when no interrupted build is found by that name
/// Throws   Error{corrupt} when no plane is whole; Error{io}, also when the build still runs, the
///          growing file is gone, or it stands beside `input` without a journal; Error{cancelled};
///          then nothing but what stood there before stands under `output`
/// Memory   24 MiB per thread, and as FileWriter and WholeBricks
std::optional<SealResult> seal_interrupted(Storage& storage, const std::string& input,
                                           const std::string& output, const SealOptions& options,
                                           Progress& progress);

}  // namespace octavo
