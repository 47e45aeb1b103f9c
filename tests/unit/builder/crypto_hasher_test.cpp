#include "octavo/builder/crypto_hasher.h"

#include <gtest/gtest.h>

#include <random>

#include "octavo/core/sha256.h"

namespace octavo {
namespace {

TEST(CryptoHasher, AgreesWithThePortableOneAtEveryLength) {
  std::mt19937 random(3);
  Bytes bytes(700);
  for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
  const auto hasher = make_crypto_hasher();
  for (std::size_t length = 0; length <= bytes.size(); ++length) {
    const ByteSpan part = ByteSpan(bytes).first(length);
    hasher->add(part.first(length / 3));
    hasher->add(part.subspan(length / 3));
    ASSERT_EQ(hasher->digest(), sha256(part)) << length;
  }
}

}  // namespace
}  // namespace octavo
