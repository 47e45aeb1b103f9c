#include "views.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/tasks/pictures/color_names.h"
#include "octavo/tasks/pictures/render.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

using ColorName = std::optional<std::string>;

AskedView view_of(const nb::dict& asked) {
  AskedView view;
  view.side = asked_for<std::string>(asked, "view");
  if (const auto steps = asked_for<std::optional<std::array<double, 3>>>(asked, "direction")) {
    view.steps = xyz_of(*steps);
  }
  view.azimuth_degrees = asked_for<std::optional<double>>(asked, "azimuth");
  view.elevation_degrees = asked_for<std::optional<double>>(asked, "elevation");
  return view;
}

/// What of the volume is drawn.
void set_content(const nb::dict& asked, RenderOptions& options) {
  using Range = std::tuple<double, double, ColorName, std::optional<double>>;
  for (const auto& [low, high, color, opacity] :
       asked_for<std::vector<Range>>(asked, "ranges")) {
    options.ranges.push_back({{low, high}, "", color_of(color), opacity});
  }
  options.tissues = asked_for<std::vector<std::string>>(asked, "tissues");
  options.labels = asked_labels(asked);
  for (const auto& [axis, keeps_below, index] :
       asked_for<std::vector<std::tuple<int, bool, std::int64_t>>>(asked, "cuts")) {
    options.cuts.push_back({axis, keeps_below, index});
  }
  using Ends = std::array<std::optional<std::int64_t>, 3>;
  for (const auto& [lo, hi] : asked_for<std::vector<std::pair<Ends, Ends>>>(asked, "removed")) {
    options.removed.push_back({{lo[2], lo[1], lo[0]}, {hi[2], hi[1], hi[0]}});
  }
  options.level = asked_for<std::optional<int>>(asked, "level");
}

AskedLabelLook label_look(const nb::dict& asked) {
  AskedLabelLook look;
  look.labels = asked_labels(asked);
  const auto text = asked_for<ColorName>(asked, "look");
  look.is_hidden = !text;
  if (!text) return look;
  look.color = find_color(*text);
  look.opacity = asked_for<std::optional<double>>(asked, "opacity");
  if (!look.color && look.opacity) color_of(*text);  // says which are known
  if (!look.color) look.transfer = *text;
  return look;
}

/// What is seen beside it, of modes with rays.
void set_company(const nb::dict& asked, RenderOptions& options) {
  for (const auto& [path, color, opacity] :
       asked_for<std::vector<std::tuple<std::string, ColorName, double>>>(asked, "meshes")) {
    options.meshes.push_back({path, color_of(color), opacity});
  }
  using Mark = std::tuple<std::array<double, 3>, std::string, ColorName>;
  for (const auto& [place, text, color] : asked_for<std::vector<Mark>>(asked, "marks")) {
    options.marks.push_back({xyz_of(place), text, color_of(color)});
  }
  options.mask = asked_for<std::string>(asked, "mask");
  options.label_map = asked_for<std::string>(asked, "label_map");
  for (const nb::dict& look : asked_for<std::vector<nb::dict>>(asked, "label_looks")) {
    options.label_looks.push_back(label_look(look));
  }
}

/// Light, and what pictures cost.
void set_light(const nb::dict& asked, RenderOptions& options) {
  options.shade = asked_word_if<RenderShade>(asked, "shade");
  options.fade = asked_for<std::optional<double>>(asked, "fade");
  options.is_average = asked_for<bool>(asked, "average");
  options.window = window_of(asked);
  options.transfer = asked_for<std::optional<std::string>>(asked, "transfer");
  options.isovalue = asked_for<std::optional<double>>(asked, "isovalue");
  options.has_ambient_shade = asked_for<bool>(asked, "ambient_shade");
  options.has_shadows = asked_for<bool>(asked, "shadows");
  options.time_budget_s = asked_for<std::optional<double>>(asked, "time_budget");
  options.is_adaptive = asked_for<bool>(asked, "adaptive");
  options.is_moving = asked_for<bool>(asked, "moving");
  options.has_smooth_edges = asked_for<bool>(asked, "smooth_edges");
}

/// Where the viewer stands, and what the picture is like.
void set_picture(const nb::dict& asked, RenderOptions& options) {
  options.view = view_of(asked);
  options.angle_degrees = asked_for<std::optional<double>>(asked, "perspective");
  const auto [width, height] =
      asked_for<std::pair<std::int64_t, std::int64_t>>(asked, "size");
  options.width = width;
  options.height = height;
  options.zoom = asked_for<double>(asked, "zoom");
  options.turntable = asked_for<int>(asked, "turntable");
  options.is_growing = asked_for<bool>(asked, "grow");
  options.background = color_of(asked_for<std::string>(asked, "background"));
  set_captions(asked_for<bool>(asked, "text"), options);
}

/// others  (name, file) of the mask and the label map beside it
nb::list render_pictures(const OpenFile& file, const std::string& name, const nb::list& others,
                         const nb::dict& asked, const nb::dict& given) {
  RenderOptions options;
  std::vector<Picture> pictures;
  options.input = name;
  options.on_picture = [&](const Picture& picture) { pictures.push_back(picture); };
  options.mode = asked_word<RenderMode>(asked, "mode");
  set_content(asked, options);
  set_company(asked, options);
  set_light(asked, options);
  set_picture(asked, options);
  run_task(render, options, named_files(file, name, others), given);
  return pixels_of_all(pictures);
}

}  // namespace

void bind_views(nb::module_& module) {
  module.def("render", &render_pictures, "file"_a, "name"_a, "others"_a, "asked"_a, "work"_a);
}

}  // namespace octavo::python
