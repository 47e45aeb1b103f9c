#include "octavo/core/text.h"

#include <charconv>
#include <cstdio>

namespace octavo {

std::string exact_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", value);
  return text;
}

std::string size_text(std::int64_t x, std::int64_t y) {
  return std::to_string(x) + " x " + std::to_string(y);
}

std::string size_text(const Size3& size) {
  return size_text(size.x, size.y) + " x " + std::to_string(size.z);
}

}  // namespace octavo
