#include "text/turn_words.h"

#include <fmt/format.h>

#include "octavo/core/error.h"
#include "text/quantities.h"

namespace octavo::cli {

namespace {

int axis_of(const std::string& text, const char* option, const std::string& whole) {
  if (text == "x") return 0;
  if (text == "y") return 1;
  if (text == "z") return 2;
  throw Error(ErrorKind::invalid_argument,
              fmt::format("{}: '{}'; expected {}", option, escaped(whole),
                          option == std::string("--rotate") ? "x, y or z and 90, 180 or 270: z:90"
                                                            : "x, y or z"));
}

}  // namespace

AxisTurn parse_turn(const std::vector<std::string>& rotations,
                    const std::vector<std::string>& mirrors) {
  AxisTurn turn;
  for (const std::string& text : rotations) {
    const std::vector<std::string> parts = split(text, ':');
    const int axis = axis_of(parts.size() == 2 ? parts[0] : "", "--rotate", text);
    const std::string& degrees = parts[1];
    if (degrees != "90" && degrees != "180" && degrees != "270" && degrees != "-90") {
      throw Error(ErrorKind::invalid_argument,
                  fmt::format("--rotate: '{}'; expected 90, 180 or 270 degrees; other angles go "
                              "with --affine",
                              escaped(text)));
    }
    const int quarters = degrees == "180" ? 2 : degrees == "90" ? 1 : 3;
    turn = chained(turn, quarter_turns(axis, quarters));
  }
  for (const std::string& text : mirrors) {
    turn = chained(turn, mirror_along(axis_of(text, "--mirror", text)));
  }
  return turn;
}

Scale parse_scale(const std::string& text) {
  constexpr std::int64_t kMost = 64;
  Scale scale;
  scale.is_up = text.rfind("1/", 0) != 0;
  const std::string number = scale.is_up ? text : text.substr(2);
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
