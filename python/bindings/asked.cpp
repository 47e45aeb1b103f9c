#include "asked.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/pair.h>

#include <cstdint>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/tasks/pictures/color_names.h"

namespace octavo::python {

namespace nb = nanobind;

void reject_word(const nb::handle& given, const char* name, std::span<const char* const> words) {
  std::string known;
  for (const char* const& word : words) {
    const bool is_last = &word == &words.back();
    known += (known.empty() ? "" : is_last ? " or " : ", ") + ("\"" + std::string(word) + "\"");
  }
  throw Error(ErrorKind::invalid_argument,
              std::string(name) + " is " + known + ", not " + nb::repr(given).c_str());
}

std::vector<NamedFile> named_files(const OpenFile& file, const std::string& name,
                                   const nb::list& others) {
  std::vector<NamedFile> files = {{name, &file}};
  for (const nb::handle one : others) {
    const auto pair = nb::cast<nb::tuple>(one);
    files.push_back({nb::cast<std::string>(pair[0]), nb::cast<const OpenFile*>(pair[1])});
  }
  return files;
}

Color color_of(const std::string& name) {
  if (const std::optional<Color> color = find_color(name)) return *color;
  throw Error(ErrorKind::invalid_argument,
              escaped(name) + " is no color; known are #rrggbb and " + color_names());
}

std::optional<Color> color_of(const std::optional<std::string>& name) {
  if (!name) return {};
  return color_of(*name);
}

std::optional<Window> window_of(const nb::dict& asked) {
  const auto ends = asked_for<std::optional<std::pair<double, double>>>(asked, "window");
  if (!ends) return {};
  return Window{(ends->first + ends->second) / 2, ends->second - ends->first};
}

nb::object pixels_of(Picture picture) {
  auto* const held = new Picture(in_colors(std::move(picture)));
  const nb::capsule owner(held, [](void* p) noexcept { delete static_cast<Picture*>(p); });
  return nb::cast(nb::ndarray<nb::numpy, std::uint8_t, nb::shape<-1, -1, 3>>(
      held->pixels.data(),
      {static_cast<std::size_t>(held->height), static_cast<std::size_t>(held->width), 3}, owner));
}

nb::list pixels_of_all(std::vector<Picture>& pictures) {
  nb::list all;
  for (Picture& picture : pictures) all.append(pixels_of(std::move(picture)));
  return all;
}

}  // namespace octavo::python
