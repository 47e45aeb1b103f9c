// Encoders and decoders share tables of passes, so that a linker keeps both. Where a program only
// reads and each kilobyte counts, as on a web page, OCTAVO_DECODERS_ALONE leaves the encoders out.
#pragma once

#include "octavo/core/error.h"

namespace octavo {

#ifdef OCTAVO_DECODERS_ALONE
inline constexpr bool kHasEncoders = false;
#else
inline constexpr bool kHasEncoders = true;
#endif

/// Stands in front of what encodes. Throws Error{internal} where it was left out.
inline void require_encoders() {
  if constexpr (!kHasEncoders) throw Error(ErrorKind::internal, "was built to read alone");
}

}  // namespace octavo
