// Numbers as text that loses nothing.
#pragma once

#include <charconv>
#include <string>

namespace octavo {

/// The shortest text that reads back as the same number.
inline std::string exact_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace octavo
