#include "octavo/file/storage/byte_source.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "octavo/core/error.h"

namespace octavo {
namespace {

constexpr std::uint64_t kMib = std::uint64_t{1} << 20;

/// Holds `there` bytes of a length that it claims, and keeps the longest request.
class ClaimingSource final : public ByteSource {
 public:
  explicit ClaimingSource(std::uint64_t there) : there_(there) {}

  std::uint64_t size() const override { return std::uint64_t{1} << 60; }
  const std::string& name() const override { return name_; }
  void read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    longest = std::max<std::uint64_t>(longest, out.size());
    if (offset + out.size() > there_) throw Error(ErrorKind::io, "breaks off", name_);
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<std::uint8_t>(offset + i);
  }

  mutable std::uint64_t longest = 0;

 private:
  std::uint64_t there_;
  std::string name_ = "claim";
};

TEST(ReadArriving, AsksForNoMoreThanCameBefore) {
  for (const std::uint64_t there : {std::uint64_t{0}, kMib, 5 * kMib}) {
    const ClaimingSource source(there);
    EXPECT_THROW(read_arriving(source, 0, std::uint64_t{1} << 50), Error);
    EXPECT_LE(source.longest, std::max(kMib, there)) << there;
  }
}

TEST(ReadArriving, GivesTheBytesInOrder) {
  const ClaimingSource source(8 * kMib);
  for (const std::uint64_t length : {std::uint64_t{0}, std::uint64_t{1}, kMib, kMib + 1,
                                     5 * kMib + 3}) {
    const std::vector<std::uint8_t> bytes = read_arriving(source, 7, length);
    ASSERT_EQ(bytes.size(), length);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      ASSERT_EQ(bytes[i], static_cast<std::uint8_t>(i + 7));
    }
  }
}

}  // namespace
}  // namespace octavo
