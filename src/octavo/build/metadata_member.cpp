#include "octavo/build/metadata_member.h"

namespace octavo {

std::string with_member(const std::string& metadata, const std::string& name,
                        const std::string& value) {
  const std::size_t end = metadata.rfind('}');
  if (end == std::string::npos) return metadata;
  const std::size_t last = metadata.find_last_not_of(" \t\r\n", end - 1);
  const bool is_empty = last == std::string::npos || metadata[last] == '{';
  return metadata.substr(0, end) + (is_empty ? "" : ",") + "\"" + name + "\":" + value + "}";
}

}  // namespace octavo
