// SHA-256 without libcrypto, for wheels: in the place of builder/crypto_hasher.cpp.
#include "octavo/builder/crypto_hasher.h"

#include "octavo/core/sha256.h"

namespace octavo {

std::unique_ptr<Hasher> make_crypto_hasher() { return std::make_unique<Sha256>(); }

}  // namespace octavo
