// SHA-256 by libcrypto, which uses the instructions of the processor.
#pragma once

#include <memory>

#include "octavo/core/hasher.h"

namespace octavo {

/// Throws Error{internal} where libcrypto has no SHA-256; std::bad_alloc
std::unique_ptr<Hasher> make_crypto_hasher();

}  // namespace octavo
