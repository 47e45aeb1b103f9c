// Is a file sound, and does it hold what its source holds?
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/url_text.h"
#include "octavo/file/repair/repair_bits.h"
#include "octavo/file/verify.h"
#include "octavo/tasks/files/plane_compare.h"
#include "octavo/tasks/inputs.h"
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
/// Throws  as verify_file, about the field "input.repair" where repair would open the file, which
///         is no URL; as open_planes and repeat_isotropic for the source
VerifyVolumeResult verify_volume(const VerifyVolumeOptions& options, const TaskContext& context);

/// How the threads and the memory of a context verify.
/// Throws Error{limit_exceeded}
VerifyOptions verify_options(const TaskContext& context);

/// Calls verify(source, options) with the file and with how this machine verifies.
/// Throws what that throws, corrupt about the field "input.repair" where repair would open the
///        file, which is no URL
template <class Verify>
auto with_verify_options(const std::string& path, const TaskContext& context, Verify verify) {
  const VerifyOptions options = verify_options(context);
  const std::shared_ptr<const ByteSource> source = open_input(path, context);
  try {
    return verify(source, options);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::corrupt || is_url(path) || !opens_repaired(source)) throw;
    throw error.with_field("input.repair");
  }
}

}  // namespace octavo
