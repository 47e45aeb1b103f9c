#include "octavo/build/metadata_member.h"

#include <nlohmann/json.hpp>

namespace octavo {

std::string with_member(const std::string& metadata, const std::string& name,
                        const std::string& value) {
  using nlohmann::ordered_json;
  ordered_json json = ordered_json::parse(metadata, nullptr, false);
  if (!json.is_object()) return metadata;
  json.erase(name);
  json[name] = ordered_json::parse(value);
  return json.dump(-1, ' ', false, ordered_json::error_handler_t::replace);
}

}  // namespace octavo
