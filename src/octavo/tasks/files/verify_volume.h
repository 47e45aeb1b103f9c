// Is a file sound, and does it hold what its source holds?
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "octavo/file/verify.h"
#include "octavo/tasks/files/plane_compare.h"
#include "octavo/tasks/open_scan.h"

namespace octavo {

struct VerifyVolumeOptions {
  std::string input;                 ///< an .8vo file or a URL of one
  std::vector<std::string> against;  ///< the source it was built from; empty: the file alone
  ScanOptions scan;                  ///< how that source is read
};

/// A sound file against its source.
struct SourceCheck {
  VolumeDescription source;  ///< as it is compared: with the planes that the build made in between
  bool has_planes_between = false;
  double allowed_error = 0;  ///< stored units: the largest that was found when the file was built
  bool is_bounded = false;   ///< a max error is promised: of floats their values count, no -0
  Comparison comparison;

  /// What is stored counts: number type, rescale and, where nothing else is promised, all bits must
  /// be the same as well.
  bool is_faithful() const {
    return is_bounded ? comparison.is_same_stored() : comparison.is_same_data();
  }
};

struct VerifyVolumeResult {
  VerifyReport report;
  VolumeDescription volume;            ///< of a sound file
  std::optional<SourceCheck> against;  ///< of a sound file, where it was asked for
};

/// Reads every byte, proves every checksum and decodes every brick; damage is part of the result.
/// Throws  as verify_file, about the field "input.repair" where repair would open the file; as
///         open_planes and repeat_isotropic for the source
VerifyVolumeResult verify_volume(const VerifyVolumeOptions& options, const TaskContext& context);

}  // namespace octavo
