// Whether the elements of a text of XML are closed: one that was cut or damaged has some that are
// not.
#pragma once

#include <string>
#include <string_view>

namespace octavo {

/// What shows that the first element of a text is damaged, as "its element Pixels is not closed";
/// empty where it is whole. What stands in front of it or behind it does not count.
std::string nesting_damage(std::string_view text);

}  // namespace octavo
