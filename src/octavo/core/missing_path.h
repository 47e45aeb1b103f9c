// Failures of a path where nothing is.
#pragma once

#include <cerrno>

#include "octavo/core/error.h"

namespace octavo {

/// The field that tells programs of it: no option changes it.
inline constexpr const char* kMissingPathField = "path.missing";

/// `error`, about that field where `code`, of errno, is that nothing is there.
inline Error told_missing(const Error& error, int code) {
  return code == ENOENT ? error.with_field(kMissingPathField) : error;
}

}  // namespace octavo
