// Where a redirect may lead.
#pragma once

#include <string>

namespace octavo {

/// The URL that `location` stands for in an answer from the URL `from`. User and password go on
/// where scheme, host and port stay the same, and nowhere else.
/// Throws Error{io} for what is no URL, for schemes other than http and https, and from https to
///        http
std::string redirect_target(const std::string& from, const std::string& location);

}  // namespace octavo
