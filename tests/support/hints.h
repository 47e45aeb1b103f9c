// Errors and warnings as one text for tests: what they say, and in brackets the options they are
// about: "a.png: 1 file is missing [on_gap=ignore]".
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/warning.h"

namespace octavo {

inline std::ostream& operator<<(std::ostream& out, const Warning& warning) {
  return out << warning.text << (warning.field.empty() ? "" : " [" + warning.field + "]");
}

namespace testing {

inline std::string with_hints(const Error& error) {
  std::string text = error.what();
  for (const auto& [field, value] : error.hints()) {
    text += " [" + field + (value.empty() ? "" : "=" + value) + "]";
  }
  return text;
}

inline std::string with_hints(const Warning& warning) {
  return warning.text + (warning.field.empty() ? "" : " [" + warning.field + "]");
}

/// One line for each.
inline std::string with_hints(const std::vector<Warning>& warnings) {
  std::string all;
  for (const Warning& warning : warnings) all += with_hints(warning) + "\n";
  return all;
}

}  // namespace testing
}  // namespace octavo
