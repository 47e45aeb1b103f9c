#include "octavo/io/serve/own_addresses.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace octavo {
namespace {

TEST(OwnAddresses, OfOneAddressIsThatOne) {
  EXPECT_EQ(own_addresses("127.0.0.1"), std::vector<std::string>{"127.0.0.1"});
  EXPECT_EQ(own_addresses("192.0.2.7"), std::vector<std::string>{"192.0.2.7"});
  EXPECT_EQ(own_addresses("::1"), std::vector<std::string>{"::1"});
}

TEST(OwnAddresses, OfAllAddressesAreThoseThatCanBeNamed) {
  for (const char* any : {"0.0.0.0", "::", "0:0::0"}) {
    const std::vector<std::string> found = own_addresses(any);
    ASSERT_FALSE(found.empty());
    for (const std::string& address : found) {
      EXPECT_NE(address, "0.0.0.0");
      EXPECT_NE(address, "::");
      EXPECT_FALSE(address.starts_with("fe80")) << address;
      EXPECT_EQ(std::count(found.begin(), found.end(), address), 1) << address;
    }
  }
  for (const std::string& address : own_addresses("0.0.0.0")) {
    EXPECT_EQ(address.find(':'), std::string::npos) << address;
  }
}

}  // namespace
}  // namespace octavo
