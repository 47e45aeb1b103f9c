#include "remaking.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/core/error.h"
#include "octavo/tasks/files/condense_volume.h"
#include "octavo/tasks/files/export_zarr_image.h"
#include "octavo/tasks/shell.h"
#include "octavo/tasks/threshold.h"
#include "octavo/tasks/transform.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

Index3 index_of_numbers(const std::vector<double>& zyx) {
  return {static_cast<std::int64_t>(zyx[2]), static_cast<std::int64_t>(zyx[1]),
          static_cast<std::int64_t>(zyx[0])};
}

/// name     of the step
/// numbers  three along z, y, x of translations, shifts and axes of rotations, which have the
///          degrees behind them; the axes of a mirror, 0 for x; a factor, below 1 of a coarser
///          grid; 12 of an affine map, row by row
TransformStep step_of(const std::string& name, const std::vector<double>& numbers,
                      bool is_in_place, bool is_inverse) {
  if (name == "translate") return TranslateStep{index_of_numbers(numbers)};
  if (name == "translate_mm") return TranslateMmStep{{numbers[2], numbers[1], numbers[0]}};
  if (name == "shift") return ShiftStep{index_of_numbers(numbers)};
  if (name == "rotate") {
    return RotateStep{{AxisRotation{{numbers[2], numbers[1], numbers[0]}, numbers[3]}},
                      is_in_place};
  }
  if (name == "mirror") {
    MirrorStep step{{}, is_in_place};
    for (const double axis : numbers) step.axes.push_back(static_cast<int>(axis));
    return step;
  }
  if (name == "scale") {
    const double factor = numbers[0];
    return ScaleStep{static_cast<std::int64_t>(factor < 1 ? 1 / factor : factor), factor >= 1,
                     is_in_place};
  }
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    std::copy_n(numbers.begin() + static_cast<std::ptrdiff_t>(4 * row), 3,
                map.linear.begin() + static_cast<std::ptrdiff_t>(3 * row));
    map.offset[row] = numbers[4 * row + 3];
  }
  return AffineStep{map, is_inverse};
}

nb::dict transform_file(const OpenFile& file, const std::string& name, const std::string& path,
                        const nb::list& steps, const OpenFile* grid, const std::string& grid_name,
                        const nb::dict& asked, const nb::dict& given) {
  TransformOptions options;
  options.input = name;
  options.output = {path, asked_for<bool>(asked, "overwrite")};
  const bool is_in_place = asked_for<bool>(asked, "in_place");
  const bool is_inverse = asked_for<bool>(asked, "inverse");
  for (const nb::handle step : steps) {
    const auto pair = nb::cast<nb::tuple>(step);
    add_step(step_of(nb::cast<std::string>(pair[0]), nb::cast<std::vector<double>>(pair[1]),
                     is_in_place, is_inverse),
             options.steps);
  }
  options.grid_of = grid == nullptr ? "" : grid_name;
  options.interpolation = asked_word_if<Interpolation>(asked, "interpolation");
  options.fill = asked_for<std::optional<double>>(asked, "fill");
  options.preset = asked_word<Preset>(asked, "preset");
  options.max_error = asked_for<double>(asked, "max_error");
  const TransformResult result =
      run_task(transform, options, {{name, &file}, {grid_name, grid}}, given);
  return dict_of({{"operation", result.operation},
                  {"summary", result.summary},
                  {"file_bytes", result.file_bytes}});
}

void condense_file(const OpenFile& file, const std::string& name, const std::string& path,
                   double flat, bool overwrite, const nb::dict& given) {
  const CondenseVolumeOptions options{name, {path, overwrite}, flat};
  run_task(condense_volume, options, {{name, &file}}, given);
}

/// Classes of values as the labels of a file.
void classify_file(const OpenFile& file, const std::string& name, const std::string& path,
                   const std::vector<std::tuple<std::int64_t, double, double>>& classes,
                   bool is_stored, const nb::dict& given) {
  ThresholdOptions options{.input = name, .output = {path, false}, .is_stored = is_stored};
  for (const auto& [label, low, high] : classes) options.classes.push_back({label, {low, high}});
  run_task(threshold, options, {{name, &file}}, given);
}

/// The leaves of a mask that lie at its surface, as a file.
void shell_file(const OpenFile& file, const std::string& name, const std::string& path,
                const nb::dict& given) {
  const ShellOptions options{name, Output{path, false}};
  run_task(shell, options, {{name, &file}}, given);
}

/// (levels, files, bytes)
nb::tuple export_zarr_file(const OpenFile& file, const std::string& name, const std::string& path,
                           const nb::dict& asked, const nb::dict& given) {
  ZarrImageOptions options{.input = name,
                           .output = {path, asked_for<bool>(asked, "overwrite")},
                           .level = asked_for<int>(asked, "level"),
                           .compression = asked_word<ZarrCompression>(asked, "compression"),
                           .chunk_side = asked_for<std::int64_t>(asked, "chunk_side"),
                           .shard_chunks = asked_for<std::int64_t>(asked, "shard_chunks")};
  const ZarrImageResult made = run_task(export_zarr_image, options, {{name, &file}}, given);
  return nb::make_tuple(made.written.levels, made.written.files, made.written.bytes);
}

/// The JSON under a key of the OME-Zarr image that a file is: of its group, or of the array of a
/// level, whose chunks are its bricks, uncompressed.
std::string zarr_text_of(const OpenFile& file, std::optional<int> level, const std::string& name) {
  const FileReader& reader = file.reader();
  const VolumeDescription& volume = reader.description();
  if (!level) {
    return ome_group_text(reader, 0, reader.levels().count(), name);
  }
  return zarr_array_text(volume.type, reader.levels().size(*level), ZarrGrid{});
}

}  // namespace

void bind_remaking(nb::module_& module) {
  module.def("transform", &transform_file, "file"_a, "name"_a, "path"_a, "steps"_a,
             "grid"_a.none(), "grid_name"_a, "asked"_a, "work"_a);
  module.def("condense", &condense_file, "file"_a, "name"_a, "path"_a, "flat"_a, "overwrite"_a,
             "work"_a);
  module.def("classify", &classify_file, "file"_a, "name"_a, "path"_a, "classes"_a, "is_stored"_a,
             "work"_a);
  module.def("shell", &shell_file, "file"_a, "name"_a, "path"_a, "work"_a);
  module.def("export_zarr", &export_zarr_file, "file"_a, "name"_a, "path"_a, "asked"_a, "work"_a);
  module.def("zarr_text", &zarr_text_of, "file"_a, "level"_a.none(), "name"_a);
}

}  // namespace octavo::python
