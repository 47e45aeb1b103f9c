// JSON text taken apart into members and put together again.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "octavo/core/json_text.h"

namespace octavo {

/// The members of an object with their values as they are written.
/// Throws  as JsonReader::next does, and Error{corrupt} where the text is no object
JsonObject json_members(std::string_view object);

/// The values of a list as they are written, in its text.
/// Throws  as json_members, where the text is no list
std::vector<std::string_view> json_items(std::string_view list);

enum class MemberOrder { as_written, by_name };

/// A value as JsonObject writes it: without spaces, with the shortest escapes and digits, and each
/// member of an object once, the last of its name where the first one stood.
/// Throws  as JsonReader::next does
std::string normal_json(std::string_view value, MemberOrder order);

}  // namespace octavo
