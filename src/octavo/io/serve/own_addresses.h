// Under which addresses others reach what listens on this machine.
#pragma once

#include <string>
#include <vector>

namespace octavo {

/// The addresses that reach a server which listens at `address`: of 0.0.0.0 and ::, which are no
/// places to connect to, those of this machine's networks, IPv4 first; where there are none, that
/// of loopback. Any other address is its own.
std::vector<std::string> own_addresses(const std::string& address);

}  // namespace octavo
