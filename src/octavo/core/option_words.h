// Words for the values of an enumeration: what options take on the command line and in Python, and
// what JSON and metadata say.
//
// An enumeration that has some has a function beside the options of its task:
//
//     constexpr auto option_words(Interpolation) {
//       return in_order<Interpolation>("nearest", "linear", "cubic");
//     }
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <utility>

namespace octavo {

template <class T>
using NamedValue = std::pair<const char*, T>;

/// Words of the values 0, 1, 2, ...
template <class T, class... Words>
constexpr std::array<NamedValue<T>, sizeof...(Words)> in_order(Words... words) {
  int value = 0;
  return {NamedValue<T>(words, static_cast<T>(value++))...};
}

/// The word of a value that has one.
template <class T>
constexpr const char* word_of(T value) {
  for (const auto& [word, meaning] : option_words(value)) {
    if (meaning == value) return word;
  }
  return "";
}

/// What a word means; nothing where it is none of them.
template <class T>
constexpr std::optional<T> value_of_word(std::string_view text) {
  for (const auto& [word, meaning] : option_words(T())) {
    if (text == word) return meaning;
  }
  return std::nullopt;
}

}  // namespace octavo
