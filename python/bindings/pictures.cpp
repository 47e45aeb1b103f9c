#include "pictures.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/tasks/pictures/slice.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

OverlayLook overlay_look(const nb::dict& asked) {
  OverlayLook look;
  look.kind = asked_word_if<OverlayKind>(asked, "kind");
  look.levels = asked_for<std::vector<double>>(asked, "levels");
  look.opacity = asked_for<std::optional<double>>(asked, "opacity");
  look.color = color_of(asked_for<std::optional<std::string>>(asked, "color"));
  return look;
}

/// Planes and montages, in place of one slice.
void set_section(const nb::dict& asked, SliceOptions& options) {
  using Numbers = std::optional<std::array<double, 3>>;
  if (const auto normal = asked_for<Numbers>(asked, "normal")) {
    const auto point = asked_for<Numbers>(asked, "point_mm");
    options.plane = AskedPlane{point ? std::optional(xyz_of(*point)) : std::nullopt,
                               xyz_of(*normal)};
  }
  const auto cells =
      asked_for<std::optional<std::pair<std::int64_t, std::int64_t>>>(asked, "montage");
  const auto every = asked_for<std::optional<std::int64_t>>(asked, "every");
  if (!cells && !every) return;
  options.montage = AskedMontage{.every = every};
  if (cells) {
    options.montage->columns = cells->first;
    options.montage->rows = cells->second;
  }
}

std::optional<SalvageFilling> salvage_filling(const nb::dict& asked) {
  const auto name = asked_for<std::optional<std::string>>(asked, "salvage");
  if (!name) return {};
  return SalvageFilling{*name == "coarse",
                        asked_for<std::optional<double>>(asked, "salvage_value")};
}

/// overlays  (name, file, look) of volumes that are drawn over it
nb::object slice_picture(const OpenFile& file, const std::string& name, const nb::list& overlays,
                         const nb::dict& asked, const nb::dict& given) {
  SliceOptions options;
  std::vector<Picture> pictures;
  options.input = name;
  options.on_picture = [&](const Picture& picture) { pictures.push_back(picture); };
  options.axes = {asked_for<int>(asked, "axis")};
  options.level = asked_for<int>(asked, "level");
  options.index = asked_for<std::optional<std::int64_t>>(asked, "index");
  options.position_mm = asked_for<std::optional<double>>(asked, "position_mm");
  set_section(asked, options);
  options.window = window_of(asked);
  options.window_preset = asked_for<std::string>(asked, "preset");
  options.minimum_side = asked_for<std::int64_t>(asked, "minimum_side");
  options.labels = asked_labels(asked);
  options.salvage = salvage_filling(asked);
  const bool has_text = asked_for<bool>(asked, "text");
  set_captions(has_text, options);
  options.has_notes = has_text;
  for (const nb::handle one : overlays) {
    const auto parts = nb::cast<nb::tuple>(one);
    options.overlays.push_back(
        {nb::cast<std::string>(parts[0]), overlay_look(nb::cast<nb::dict>(parts[2]))});
  }
  run_task(slice, options, named_files(file, name, overlays), given);
  return pixels_of(std::move(pictures.front()));
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
  module.def("png", &png_of, "pixels"_a);
}

}  // namespace octavo::python
