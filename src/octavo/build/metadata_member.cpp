#include "octavo/build/metadata_member.h"

#include <algorithm>

namespace octavo {

namespace {

/// Behind the string whose quote stands at `at`.
std::size_t end_of_string(const std::string& json, std::size_t at) {
  ++at;
  while (at < json.size() && json[at] != '"') at += json[at] == '\\' ? 2 : 1;
  return std::min(at + 1, json.size());
}

/// Takes out the first member `name` of the object; false when there is none.
bool erase_member(std::string& json, const std::string& name) {
  const std::string key = "\"" + name + "\"";
  constexpr std::size_t kNone = std::string::npos;
  std::size_t member = kNone;
  std::size_t comma = kNone;  ///< before the member in work
  bool is_key = true;
  int depth = 0;
  for (std::size_t at = 0; at < json.size(); ++at) {
    const char c = json[at];
    if (c == '"') {
      const std::size_t end = end_of_string(json, at);
      const bool is_name = json.compare(at, end - at, key) == 0;
      if (depth == 1 && is_key && is_name) member = at;
      is_key = false;
      at = end - 1;
    } else if (c == '{' || c == '[') {
      ++depth;
    } else if (c == '}' || c == ']') {
      if (--depth > 0 || member == kNone) continue;
      const std::size_t start = comma == kNone ? member : comma;
      json.erase(start, at - start);
      return true;
    } else if (c == ',' && depth == 1) {
      if (member != kNone) {
        json.erase(member, at + 1 - member);
        return true;
      }
      comma = at;
      is_key = true;
    }
  }
  return false;
}

}  // namespace

std::string with_member(const std::string& metadata, const std::string& name,
                        const std::string& value) {
  std::string json = metadata;
  while (erase_member(json, name)) {
  }
  const std::size_t end = json.rfind('}');
  if (end == std::string::npos) return metadata;
  const std::size_t last = json.find_last_not_of(" \t\r\n", end - 1);
  const bool is_empty = last == std::string::npos || json[last] == '{';
  return json.substr(0, end) + (is_empty ? "" : ",") + "\"" + name + "\":" + value + "}";
}

}  // namespace octavo
