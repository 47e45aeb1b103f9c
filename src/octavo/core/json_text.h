// Values as JSON text: one line without spaces, members in the order in which they were set.
#pragma once

#include <concepts>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "octavo/core/json_number.h"

namespace octavo {

/// In quotes, escaped where JSON asks for it; U+FFFD in place of what is no UTF-8. Longer ones than
/// readers take (kMaxJsonStringBytes) are cut behind a character.
std::string json_string(std::string_view text);

struct JsonMember {
  std::string name;
  std::string json;  ///< the value
};

/// An object that is being written.
class JsonObject {
 public:
  /// Sets a member to a bool, a number, a text, an object or a list of such: behind the others,
  /// or in place of the one of that name.
  template <class T>
  JsonObject& set(std::string_view name, const T& value);
  /// The same with a value that is JSON already.
  JsonObject& set_json(std::string_view name, std::string json);
  /// Puts a member behind the others without a look at their names.
  void append(std::string name, std::string json);
  /// Removes every member of that name.
  void erase(std::string_view name);

  bool is_empty() const { return members_.empty(); }
  const std::vector<JsonMember>& members() const { return members_; }
  /// The value of a member as JSON; empty where there is none.
  std::string_view json_of(std::string_view name) const;
  void sort_by_name();
  std::string text() const;

 private:
  std::vector<JsonMember> members_;
};

/// Any value that JsonObject::set takes, as JSON.
template <class T>
std::string json_text(const T& value) {
  if constexpr (std::is_same_v<T, bool>) {
    return value ? "true" : "false";
  } else if constexpr (std::integral<T>) {
    return std::to_string(value);
  } else if constexpr (std::floating_point<T>) {
    return json_number(value);
  } else if constexpr (std::is_convertible_v<const T&, std::string_view>) {
    return json_string(value);
  } else if constexpr (std::is_same_v<T, JsonObject>) {
    return value.text();
  } else {
    std::string list;
    for (const auto& item : value) list += (list.empty() ? "[" : ",") + json_text(item);
    return list.empty() ? "[]" : list + "]";
  }
}

template <class T>
JsonObject& JsonObject::set(std::string_view name, const T& value) {
  return set_json(name, json_text(value));
}

}  // namespace octavo
