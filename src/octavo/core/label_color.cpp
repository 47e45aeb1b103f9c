#include "octavo/core/label_color.h"

namespace octavo {

namespace {

struct Shade {
  int saturation;  // of 256
  int value;       // of 255
};

constexpr Shade kShades[] = {{200, 255}, {140, 230}, {230, 175}};

/// The hexcone model in integers: hue 0 .. 65535 runs red, yellow, green, cyan, blue, magenta.
LabelColor color_of_hue(unsigned hue, const Shade& shade) {
  const unsigned scaled = hue * 6;
  const int sector = static_cast<int>(scaled >> 16);
  const int part = static_cast<int>(scaled >> 8 & 0xff);
  const auto level = [&](int share) {
    return static_cast<std::uint8_t>(shade.value - shade.value * shade.saturation * share / 65536);
  };
  const std::uint8_t high = level(0);
  const std::uint8_t low = level(256);
  const std::uint8_t rising = level(256 - part);
  const std::uint8_t falling = level(part);
  switch (sector) {
    case 0: return {high, rising, low};
    case 1: return {falling, high, low};
    case 2: return {low, high, rising};
    case 3: return {low, falling, high};
    case 4: return {rising, low, high};
    default: return {high, low, falling};
  }
}

}  // namespace

LabelColor label_color(std::int64_t label) {
  if (label == 0) return {0, 0, 0};
  constexpr std::uint64_t kGoldenStep = 40503;  // 65536 / golden ratio
  const auto number = static_cast<std::uint64_t>(label);
  const auto hue = static_cast<unsigned>(number * kGoldenStep & 0xffff);
  return color_of_hue(hue, kShades[number % 3]);
}

}  // namespace octavo
