// What a task found, by name, as every face shows it: an object of JSON, a dictionary of Python.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

namespace octavo {

struct Fact;
using Facts = std::vector<Fact>;  ///< in the order in which they are shown

/// Nothing, a bool, a number, a text, a list, or facts with names of their own.
class FactValue {
 public:
  using List = std::vector<FactValue>;
  using Held = std::variant<std::monostate, bool, std::int64_t, std::uint64_t, double,
                            std::string, List, Facts>;

  FactValue() = default;
  /// Of a bool, a number, a text, facts, a list of such, or an optional of any.
  template <class T>
    requires(!std::same_as<T, FactValue>)
  FactValue(const T& value);

  const Held& held() const { return held_; }

 private:
  Held held_;
};

struct Fact {
  std::string name;
  FactValue value;
};

/// Facts of what is there, or nothing.
template <class T, class Of>
FactValue facts_if(const std::optional<T>& value, Of of) {
  return value ? FactValue(of(*value)) : FactValue();
}

/// Facts of each one of `all`, as a list.
template <class All, class Of>
FactValue list_of_facts(const All& all, Of of) {
  std::vector<Facts> list;
  for (const auto& one : all) list.push_back(of(one));
  return list;
}

// ---- implementation of the template

template <class T>
  requires(!std::same_as<T, FactValue>)
FactValue::FactValue(const T& value) {
  if constexpr (requires { value.has_value(); }) {
    if (value) held_ = FactValue(*value).held_;
  } else if constexpr (std::same_as<T, bool>) {
    held_ = value;
  } else if constexpr (std::signed_integral<T>) {
    held_ = static_cast<std::int64_t>(value);
  } else if constexpr (std::unsigned_integral<T>) {
    held_ = static_cast<std::uint64_t>(value);
  } else if constexpr (std::floating_point<T>) {
    held_ = static_cast<double>(value);
  } else if constexpr (std::convertible_to<const T&, std::string_view>) {
    held_ = std::string(std::string_view(value));
  } else if constexpr (std::same_as<T, Facts>) {
    held_ = value;
  } else {
    held_ = List(value.begin(), value.end());
  }
}

}  // namespace octavo
