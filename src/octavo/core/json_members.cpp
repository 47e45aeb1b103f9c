#include "octavo/core/json_members.h"

#include <charconv>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "octavo/core/error.h"
#include "octavo/core/json_reader.h"

namespace octavo {

namespace {

std::string normal_value(JsonReader& in, MemberOrder order);

std::string normal_integer(const JsonReader& in) {
  const std::string_view written = in.written();
  std::uint64_t magnitude = 0;
  const auto end = written.data() + written.size();
  const bool fits = std::from_chars(written.data(), end, magnitude).ec == std::errc();
  if (const auto value = in.integer()) return std::to_string(*value);
  return fits ? std::string(written) : json_number(in.number().value_or(HUGE_VAL));
}

std::string normal_object(JsonReader& in, MemberOrder order) {
  std::vector<JsonMember> members;
  std::unordered_map<std::string, std::size_t> places;
  while (in.next() != JsonToken::end_object) {
    std::string name = in.string();
    in.next();
    std::string value = normal_value(in, order);
    const auto [place, is_new] = places.try_emplace(name, members.size());
    if (is_new) members.push_back({std::move(name), std::move(value)});
    else members[place->second].json = std::move(value);
  }
  JsonObject object;
  for (JsonMember& member : members) object.append(std::move(member.name), std::move(member.json));
  if (order == MemberOrder::by_name) object.sort_by_name();
  return object.text();
}

std::string normal_list(JsonReader& in, MemberOrder order) {
  std::string list = "[";
  while (in.next() != JsonToken::end_list) {
    list += (list.size() > 1 ? "," : "") + normal_value(in, order);
  }
  return list + "]";
}

/// Deep objects end in the limits of the reader.
std::string normal_value(JsonReader& in, MemberOrder order) {
  switch (in.token()) {
    case JsonToken::begin_object: return normal_object(in, order);
    case JsonToken::begin_list: return normal_list(in, order);
    case JsonToken::string: return json_string(in.string());
    case JsonToken::integer: return normal_integer(in);
    case JsonToken::number: return json_number(in.number().value_or(HUGE_VAL));
    default: return std::string(in.written());
  }
}

}  // namespace

JsonObject json_members(std::string_view object) {
  JsonReader in(object);
  if (in.next() != JsonToken::begin_object) throw Error(ErrorKind::corrupt, "no object");
  JsonObject members;
  while (in.next() != JsonToken::end_object) {
    std::string name = in.string();
    in.next();
    members.append(std::move(name), std::string(in.skip_value()));
  }
  in.next();
  return members;
}

std::vector<std::string_view> json_items(std::string_view list) {
  JsonReader in(list);
  if (in.next() != JsonToken::begin_list) throw Error(ErrorKind::corrupt, "no list");
  std::vector<std::string_view> items;
  while (in.next() != JsonToken::end_list) items.push_back(in.skip_value());
  in.next();
  return items;
}

std::string normal_json(std::string_view value, MemberOrder order) {
  JsonReader in(value);
  in.next();
  std::string json = normal_value(in, order);
  in.next();
  return json;
}

}  // namespace octavo
