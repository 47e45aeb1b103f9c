#include "octavo/tasks/pictures/color_names.h"

#include <charconv>

namespace octavo {

namespace {

struct Named {
  std::string_view name;
  Color color;
};

constexpr Named kNamed[] = {
    {"black", {0, 0, 0}},        {"white", {255, 255, 255}}, {"grey", {128, 128, 128}},
    {"red", {220, 40, 40}},      {"green", {40, 160, 60}},   {"blue", {50, 90, 220}},
    {"yellow", {245, 215, 60}},  {"orange", {240, 140, 40}}, {"cyan", {60, 200, 220}},
    {"magenta", {210, 70, 190}}, {"navy", {12, 18, 48}},     {"sand", {236, 226, 204}},
    {"steel", {150, 170, 190}}};

}  // namespace

std::optional<Color> find_color(std::string_view text) {
  for (const Named& named : kNamed) {
    if (named.name == text) return named.color;
  }
  if (text.size() != 7 || text[0] != '#') return std::nullopt;
  Color color{};
  for (std::size_t i = 0; i < 3; ++i) {
    const char* const begin = text.data() + 1 + 2 * i;
    const auto read = std::from_chars(begin, begin + 2, color[i], 16);
    if (read.ec != std::errc() || read.ptr != begin + 2) return std::nullopt;
  }
  return color;
}

std::vector<std::string_view> named_colors() {
  std::vector<std::string_view> names;
  for (const Named& named : kNamed) names.push_back(named.name);
  return names;
}

std::string color_names() {
  std::string names;
  for (const std::string_view name : named_colors()) {
    names += (names.empty() ? "" : ", ") + std::string(name);
  }
  return names;
}

}  // namespace octavo
