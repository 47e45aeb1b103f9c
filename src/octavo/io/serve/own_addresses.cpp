#include "octavo/io/serve/own_addresses.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <memory>

namespace octavo {

namespace {

/// The address of a network that others can name; nothing for loopback, for other families and for
/// those of one link, which mean nothing without its name.
std::string network_address(const ifaddrs& network, int family) {
  const bool is_used = network.ifa_addr != nullptr && (network.ifa_flags & IFF_UP) != 0 &&
                       (network.ifa_flags & IFF_LOOPBACK) == 0;
  if (!is_used || network.ifa_addr->sa_family != family) return "";
  char text[INET6_ADDRSTRLEN] = {};
  if (family == AF_INET) {
    const auto* v4 = reinterpret_cast<const sockaddr_in*>(network.ifa_addr);
    ::inet_ntop(family, &v4->sin_addr, text, sizeof text);
  } else {
    const auto* v6 = reinterpret_cast<const sockaddr_in6*>(network.ifa_addr);
    if (IN6_IS_ADDR_LINKLOCAL(&v6->sin6_addr)) return "";
    ::inet_ntop(family, &v6->sin6_addr, text, sizeof text);
  }
  return text;
}

}  // namespace

std::vector<std::string> own_addresses(const std::string& address) {
  in_addr v4{};
  in6_addr v6{};
  const bool is_any_v4 = ::inet_pton(AF_INET, address.c_str(), &v4) == 1 && v4.s_addr == 0;
  const bool is_any_v6 =
      ::inet_pton(AF_INET6, address.c_str(), &v6) == 1 && IN6_IS_ADDR_UNSPECIFIED(&v6);
  if (!is_any_v4 && !is_any_v6) return {address};
  std::vector<std::string> found;
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) == 0) {
    const std::unique_ptr<ifaddrs, decltype(&::freeifaddrs)> owner(all, ::freeifaddrs);
    for (const int family : {AF_INET, AF_INET6}) {
      if (family == AF_INET6 && !is_any_v6) continue;
      for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
        const std::string text = network_address(*one, family);
        const bool is_new = std::find(found.begin(), found.end(), text) == found.end();
        if (!text.empty() && is_new) found.push_back(text);
      }
    }
  }
  if (found.empty()) found.emplace_back(is_any_v4 ? "127.0.0.1" : "::1");
  return found;
}

}  // namespace octavo
