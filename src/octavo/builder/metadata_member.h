// Metadata with one thing more in it.
#pragma once

#include <string>

namespace octavo {

/// The JSON object `metadata` with the member `name` behind all others, in place of one of
/// that name; as it is when it is no object.
/// value  JSON
std::string with_member(const std::string& metadata, const std::string& name,
                        const std::string& value);

}  // namespace octavo
