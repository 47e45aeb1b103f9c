#include "octavo/core/json_text.h"

#include <algorithm>
#include <cstdint>

#include "octavo/core/json_reader.h"
#include "octavo/core/utf8.h"

namespace octavo {

namespace {

std::string escape_of(char c) {
  constexpr std::string_view kMeant = "\"\\\b\f\n\r\t";
  constexpr std::string_view kWritten = "\"\\bfnrt";
  constexpr std::string_view kHexDigits = "0123456789abcdef";
  if (const std::size_t index = kMeant.find(c); index != std::string_view::npos) {
    return {'\\', kWritten[index]};
  }
  const auto byte = static_cast<std::uint8_t>(c);
  return {'\\', 'u', '0', '0', kHexDigits[byte >> 4], kHexDigits[byte & 15]};
}

}  // namespace

std::string json_string(std::string_view text) {
  const std::string valid = as_utf8(text);
  std::string json = "\"";
  for (const char c : cut_utf8(valid, kMaxJsonStringBytes)) {
    const bool is_plain = static_cast<std::uint8_t>(c) >= 0x20 && c != '"' && c != '\\';
    if (is_plain) json += c;
    else json += escape_of(c);
  }
  return json + "\"";
}

JsonObject& JsonObject::set_json(std::string_view name, std::string json) {
  const auto found = std::find_if(members_.begin(), members_.end(),
                                  [&](const JsonMember& member) { return member.name == name; });
  if (found != members_.end()) found->json = std::move(json);
  else append(std::string(name), std::move(json));
  return *this;
}

void JsonObject::append(std::string name, std::string json) {
  members_.push_back({std::move(name), std::move(json)});
}

void JsonObject::erase(std::string_view name) {
  std::erase_if(members_, [&](const JsonMember& member) { return member.name == name; });
}

std::string_view JsonObject::json_of(std::string_view name) const {
  for (const JsonMember& member : members_) {
    if (member.name == name) return member.json;
  }
  return {};
}

void JsonObject::sort_by_name() {
  std::sort(members_.begin(), members_.end(),
            [](const JsonMember& a, const JsonMember& b) { return a.name < b.name; });
}

std::string JsonObject::text() const {
  std::string json = "{";
  for (const JsonMember& member : members_) {
    json += (json.size() > 1 ? "," : "") + json_string(member.name) + ":" + member.json;
  }
  return json + "}";
}

}  // namespace octavo
