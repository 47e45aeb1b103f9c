#include "text/turn_words.h"

#include <fmt/format.h>

#include <bit>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

int axis_of(const std::string& text, const char* option, const std::string& whole,
            const char* expected) {
  if (text == "x") return 0;
  if (text == "y") return 1;
  if (text == "z") return 2;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{}: '{}'; expected {}", option, escaped(whole), expected));
}

}  // namespace

AxisRotation parse_rotation(const std::string& text) {
  constexpr const char* kExpected = "an axis and degrees, as in z:90, x:-12.5 or 1,1,0:30";
  const std::vector<std::string> parts = split(text, ':');
  if (parts.size() != 2) axis_of("", "--rotate", text, kExpected);
  AxisRotation rotation;
  if (split(parts[0], ',').size() == 3) {
    rotation.axis = parse_point(parts[0], "--rotate");
  } else {
    rotation.axis = {0, 0, 0};
    rotation.axis[static_cast<std::size_t>(axis_of(parts[0], "--rotate", text, kExpected))] = 1;
  }
  rotation.degrees = parse_number(parts[1], "--rotate");
  if (rotation.axis != Point3{0, 0, 0}) return rotation;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("--rotate: '{}'; the axis 0,0,0 has no direction", escaped(text)));
}

int parse_mirror(const std::string& text) {
  return axis_of(text, "--mirror", text, "x, y or z");
}

ScaleStep parse_scale(const std::string& text) {
  constexpr std::int64_t kMost = 64;
  ScaleStep scale;
  scale.is_finer = text.rfind("1/", 0) != 0;
  const std::string number = scale.is_finer ? text : text.substr(2);
  const bool is_short =
      !number.empty() && number.size() <= 2 &&
      number.find_first_not_of("0123456789") == std::string::npos;
  scale.factor = is_short ? parse_integer(number, "--scale") : 0;
  if (scale.factor < 2 || scale.factor > kMost ||
      !std::has_single_bit(static_cast<std::uint64_t>(scale.factor))) {
    throw Error(ErrorKind::invalid_argument,
                fmt::format("--scale: '{}'; expected a power of two: 2, 4, ... 64 or 1/2, 1/4, ... "
                            "1/64; other factors go with --affine and --grid-of",
                            escaped(text)));
  }
  return scale;
}

}  // namespace octavo::cli
