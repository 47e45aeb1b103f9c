// SHA-256 of bytes that come one after another, by whatever computes it.
//
// The library below has a portable one (core/sha256.h); faster ones come in from above.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>

#include "octavo/core/bytes.h"

namespace octavo {

using Sha256Digest = std::array<std::uint8_t, 32>;

/// One thread at a time.
class Hasher {
 public:
  virtual ~Hasher() = default;

  virtual void add(ByteSpan bytes) = 0;

  /// The digest of what was added since the start or the last call.
  virtual Sha256Digest digest() = 0;
};

/// Makes a hasher; called from any thread.
using MakeHasher = std::function<std::unique_ptr<Hasher>()>;

}  // namespace octavo
