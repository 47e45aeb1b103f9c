// Text inside XML.
#pragma once

#include <string>
#include <string_view>

namespace octavo {

/// Text between tags, or between the quotes of an attribute: escaped where XML asks for it, U+FFFD
/// in place of what is no UTF-8 or no character of XML, spaces in place of line ends and tabs.
std::string xml_text(std::string_view text);

}  // namespace octavo
