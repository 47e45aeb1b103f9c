#include "octavo/core/sha256.h"

#include <gtest/gtest.h>

#include <string>

namespace octavo {
namespace {

std::string hex_of(const std::string& text) {
  return hex_text(sha256({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}));
}

// Examples of FIPS 180-4, and NIST's vectors whose padding is at its edges.
TEST(Sha256, GivesTheDigestsOfNist) {
  EXPECT_EQ(hex_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hex_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(hex_of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(hex_of("abcdefghbcdefghicdefghijdefghijkefghijklfghijklmghijklmn"
                   "hijklmnoijklmnopjklmnopqklmnopqrlmnopqrsmnopqrstnopqrstu"),
            "cf5b16a778af8380036ce59e7b0492370b249b11e8f07a51afac45037afee9d1");
  EXPECT_EQ(hex_of(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  EXPECT_EQ(hex_of(std::string(1, '\xbd')),
            "68325720aabd7c82f30f554b313d0570c95accbb7dc4b5aae11204c08ffe732b");
  EXPECT_EQ(hex_of(std::string(55, '\0')),
            "02779466cdec163811d078815c633f21901413081449002f24aa3e80f0b88ef7");
  EXPECT_EQ(hex_of(std::string(56, '\0')),
            "d4817aa5497628e7c77e6b606107042bbba3130888c5f47a375e6179be789fbb");
  EXPECT_EQ(hex_of(std::string(64, '\0')),
            "f5a5fd42d16a20302798ef6ed309979b43003d2320d9f0e8ea9831a92759fb4b");
}

TEST(Sha256, DoesNotDependOnHowBytesAreCut) {
  Bytes bytes(1000);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i * 7);
  const Sha256Digest whole = sha256(bytes);
  Sha256 hasher;
  for (std::size_t step = 1; step < 200; ++step) {
    for (std::size_t at = 0; at < bytes.size(); at += step) {
      hasher.add(ByteSpan(bytes).subspan(at, std::min(step, bytes.size() - at)));
    }
    // A digest starts the hasher anew.
    EXPECT_EQ(hasher.digest(), whole) << step;
  }
}

}  // namespace
}  // namespace octavo
