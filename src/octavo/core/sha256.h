// SHA-256 on every machine.
//
// Source  FIPS 180-4, sections 5.1.1, 5.3.3 and 6.2
#pragma once

#include <cstddef>
#include <string>

#include "octavo/core/hasher.h"
#include "octavo/core/sha256_constants.h"

namespace octavo {

class Sha256 final : public Hasher {
 public:
  void add(ByteSpan bytes) override;
  Sha256Digest digest() override;

 private:
  static constexpr std::size_t kBlockBytes = 64;

  void add_block(const std::uint8_t* block) noexcept;

  std::array<std::uint32_t, 8> state_ = kSha256Start;
  std::array<std::uint8_t, kBlockBytes> rest_{};  ///< of a block that is not full
  std::uint64_t byte_count_ = 0;
};

/// The digest of `bytes`.
Sha256Digest sha256(ByteSpan bytes);

/// 64 small hexadecimal digits, as sha256sum prints them.
std::string hex_text(const Sha256Digest& digest);

}  // namespace octavo
