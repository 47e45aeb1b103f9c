#include "octavo/core/recycled.h"

#include <gtest/gtest.h>

#include <thread>
#include <utility>
#include <vector>

namespace octavo {
namespace {

struct FirstUse {};
struct OtherUse {};
using FirstBytes = Recycled<UnsetBytes, FirstUse>;
using OtherBytes = Recycled<UnsetBytes, OtherUse>;

TEST(Recycled, MemoryGoesToTheNextOfItsUseInTheThread) {
  const std::byte* memory = nullptr;
  {
    FirstBytes bytes;
    bytes->resize(1000);
    memory = bytes->data();
  }
  const OtherBytes other;
  EXPECT_EQ(other->capacity(), 0u);
  std::thread([] { EXPECT_EQ(FirstBytes()->capacity(), 0u); }).join();
  FirstBytes next;
  next->resize(900);
  EXPECT_EQ(next->data(), memory);
  EXPECT_EQ(FirstBytes()->capacity(), 0u);
}

TEST(Recycled, IsKeptByTheThreadThatIsDoneWithIt) {
  FirstBytes bytes;
  bytes->resize(2000);
  std::thread([own = std::move(bytes)]() mutable {
    const std::byte* const memory = own->data();
    { const FirstBytes gone = std::move(own); }
    const FirstBytes next;
    EXPECT_EQ(next->data(), memory);
  }).join();
}

TEST(Recycled, WhatIsHeldIsLittleLargerThanAskedFor) {
  {
    FirstBytes bytes;
    bytes->resize(100'000);
  }
  {
    FirstBytes held;
    held.hold(1000);
    EXPECT_EQ(held->size(), 1000u);
    EXPECT_LE(held->capacity(), 2000u);
  }
  FirstBytes next;
  const std::byte* const memory = next->data();
  next.hold(600);
  EXPECT_EQ(next->data(), memory);
}

TEST(Recycled, LargeBuffersAndManyAreGivenBack) {
  using ManyBytes = Recycled<std::array<Bytes, 2>, FirstUse>;
  {
    ManyBytes bytes;
    (*bytes)[0].resize(ManyBytes::kMostBytes);
    (*bytes)[1].resize(1);
  }
  EXPECT_EQ(capacity_of(*ManyBytes()), 0u);
  {
    std::vector<ManyBytes> many(ManyBytes::kMostKept + 2);
    for (ManyBytes& bytes : many) (*bytes)[0].resize(100);
  }
  std::vector<ManyBytes> again(ManyBytes::kMostKept + 2);
  std::size_t kept = 0;
  for (const ManyBytes& bytes : again) {
    if (capacity_of(*bytes) > 0) ++kept;
  }
  EXPECT_EQ(kept, ManyBytes::kMostKept);
}

}  // namespace
}  // namespace octavo
