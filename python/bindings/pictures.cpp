#include "pictures.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"
#include "octavo/tasks/pictures/slice.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

/// An array of pixels [y, x, 3].
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

/// A window (low, high) in real values.
std::optional<Window> window_of(const nb::dict& asked) {
  const auto ends = nb::cast<std::optional<std::pair<double, double>>>(asked["window"]);
  if (!ends) return {};
  return Window{(ends->first + ends->second) / 2, ends->second - ends->first};
}

Color color_of(const std::string& name) {
  if (const std::optional<Color> color = find_color(name)) return *color;
  throw Error(ErrorKind::invalid_argument,
              escaped(name) + " is no color; known are #rrggbb and " + color_names());
}

void set_captions(bool has_text, auto& options) {
  options.has_scale_bar = has_text;
  options.has_sides = has_text;
  options.has_legend = has_text;
}

/// overlays  (name, file) of volumes that are drawn over it
nb::object slice_picture(const OpenFile& file, const std::string& name, const nb::list& overlays,
                         const nb::dict& asked, const nb::dict& given) {
  SliceOptions options;
  std::vector<Picture> pictures;
  options.input = name;
  options.on_picture = [&](const Picture& picture) { pictures.push_back(picture); };
  options.axes = {nb::cast<int>(asked["axis"])};
  options.level = nb::cast<int>(asked["level"]);
  options.index = nb::cast<std::optional<std::int64_t>>(asked["index"]);
  options.position_mm = nb::cast<std::optional<double>>(asked["position_mm"]);
  options.window = window_of(asked);
  options.window_preset = nb::cast<std::string>(asked["preset"]);
  options.minimum_side = nb::cast<std::int64_t>(asked["minimum_side"]);
  const bool has_text = nb::cast<bool>(asked["text"]);
  set_captions(has_text, options);
  options.has_notes = has_text;
  std::vector<NamedFile> files = {{name, &file}};
  for (const nb::handle one : overlays) {
    const auto pair = nb::cast<nb::tuple>(one);
    files.push_back({nb::cast<std::string>(pair[0]), nb::cast<const OpenFile*>(pair[1])});
    options.overlays.push_back({files.back().name, {}});
  }
  Work work(given);
  work.run(files, [&] { slice(options, work.context()); });
  return pixels_of(std::move(pictures.front()));
}

RenderMode render_mode_of(const std::string& name) {
  if (name == "surface") return RenderMode::surface;
  if (name == "transparency") return RenderMode::transparency;
  if (name == "volume") return RenderMode::volume;
  if (name == "mip") return RenderMode::mip;
  if (name == "minip") return RenderMode::minip;
  if (name == "mean") return RenderMode::mean;
  if (name == "iso") return RenderMode::iso;
  return RenderMode::cubes;
}

AskedView view_of(const nb::dict& asked) {
  AskedView view;
  view.side = nb::cast<std::string>(asked["view"]);
  view.azimuth_degrees = nb::cast<std::optional<double>>(asked["azimuth"]);
  view.elevation_degrees = nb::cast<std::optional<double>>(asked["elevation"]);
  return view;
}

nb::list render_pictures(const OpenFile& file, const std::string& name, const nb::dict& asked,
                         const nb::dict& given) {
  RenderOptions options;
  std::vector<Picture> pictures;
  options.input = name;
  options.on_picture = [&](const Picture& picture) { pictures.push_back(picture); };
  options.mode = render_mode_of(nb::cast<std::string>(asked["mode"]));
  options.level = nb::cast<std::optional<int>>(asked["level"]);
  for (const auto& [low, high] :
       nb::cast<std::vector<std::pair<double, double>>>(asked["ranges"])) {
    options.ranges.push_back({.range = {low, high}});
  }
  options.tissues = nb::cast<std::vector<std::string>>(asked["tissues"]);
  options.labels = {nb::cast<std::vector<std::int64_t>>(asked["labels"]),
                    nb::cast<std::vector<std::string>>(asked["names"])};
  options.view = view_of(asked);
  const auto [width, height] =
      nb::cast<std::pair<std::int64_t, std::int64_t>>(asked["size"]);
  options.width = width;
  options.height = height;
  options.zoom = nb::cast<double>(asked["zoom"]);
  options.turntable = nb::cast<int>(asked["turntable"]);
  options.background = color_of(nb::cast<std::string>(asked["background"]));
  options.window = window_of(asked);
  options.transfer = nb::cast<std::optional<std::string>>(asked["transfer"]);
  options.isovalue = nb::cast<std::optional<double>>(asked["isovalue"]);
  set_captions(nb::cast<bool>(asked["text"]), options);
  Work work(given);
  work.run({{name, &file}}, [&] { render(options, work.context()); });
  return pixels_of_all(pictures);
}

nb::bytes png_of(const nb::ndarray<const std::uint8_t, nb::shape<-1, -1, 3>, nb::c_contig,
                                   nb::device::cpu>& pixels) {
  Picture picture = make_picture(static_cast<std::int64_t>(pixels.shape(1)),
                                 static_cast<std::int64_t>(pixels.shape(0)), 3);
  std::copy_n(pixels.data(), picture.pixels.size(), picture.pixels.begin());
  const Bytes file = encode_png(picture);
  return nb::bytes(file.data(), file.size());
}

}  // namespace

void bind_pictures(nb::module_& module) {
  module.def("slice", &slice_picture, "file"_a, "name"_a, "overlays"_a, "asked"_a, "work"_a);
  module.def("render", &render_pictures, "file"_a, "name"_a, "asked"_a, "work"_a);
  module.def("png", &png_of, "pixels"_a);
}

}  // namespace octavo::python
