#include "octavo/builder/crypto_hasher.h"

#include <gtest/gtest.h>
#include <openssl/crypto.h>

#include <cstdlib>
#include <new>
#include <random>

#include "octavo/core/sha256.h"

namespace octavo {
namespace {

// How many more allocations of libcrypto succeed; -1: all.
thread_local int allocations_left = -1;

bool may_allocate() {
  if (allocations_left == 0) return false;
  if (allocations_left > 0) --allocations_left;
  return true;
}

void* allocate(std::size_t size, const char*, int) {
  return may_allocate() ? std::malloc(size) : nullptr;
}
void* reallocate(void* block, std::size_t size, const char*, int) {
  return may_allocate() ? std::realloc(block, size) : nullptr;
}
void release(void* block, const char*, int) { std::free(block); }

// libcrypto takes them before its first allocation alone.
const bool kIsHooked = CRYPTO_set_mem_functions(allocate, reallocate, release) == 1;

TEST(CryptoHasher, LackOfMemoryIsReportedAsSuch) {
  ASSERT_TRUE(kIsHooked);
  make_crypto_hasher();  // what libcrypto makes once
  int failures = 0;
  for (bool is_done = false; !is_done; ++failures) {
    allocations_left = failures;
    try {
      make_crypto_hasher();
      is_done = true;
    } catch (const std::bad_alloc&) {
      is_done = false;
    }
    allocations_left = -1;
  }
  EXPECT_GT(failures, 1);
}

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
