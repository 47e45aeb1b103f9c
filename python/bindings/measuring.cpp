#include "measuring.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <vector>

#include "facts.h"
#include "octavo/core/error.h"
#include "octavo/core/sha256.h"
#include "octavo/core/text.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/files/plane_compare.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/measure.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

/// A number for each axis x, y, z; None where nothing is known.
void set_axes(nb::dict& row, const std::string& before, const std::string& after,
              const std::optional<Point3>& point) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::string name = before + "xyz"[axis] + after;
    row[name.c_str()] = point ? nb::cast((*point)[axis]) : nb::none();
  }
}

/// The columns that `octavo measure --csv` has.
nb::dict region_row(const MeasuredRegion& one, const MeasureResult& result) {
  const RegionMeasure& region = one.region;
  nb::dict row;
  row["label"] = region.label;
  row["name"] = result.names.name_of(region.label);
  row["voxels"] = region.voxel_count;
  row["mm3"] = one.in_mm ? nb::cast(one.in_mm->mm3) : nb::none();
  row["surface_voxels"] = region.surface_voxel_count;
  const auto in_mm = [&](auto member) {
    return one.in_mm ? std::optional<Point3>(member(*one.in_mm)) : std::nullopt;
  };
  set_axes(row, "centroid_", "_mm", in_mm([](const RegionInMm& mm) { return mm.centroid; }));
  set_axes(row, "centroid_", "_voxel", region.centroid);
  for (int axis = 0; axis < 3; ++axis) {
    const std::string name = std::string("box_") + "xyz"[axis];
    row[(name + "_lo").c_str()] = region.box.lo[axis];
    row[(name + "_hi").c_str()] = region.box.hi[axis];
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const std::string name = "principal_moment_" + std::to_string(i + 1) + "_mm2";
    row[name.c_str()] = one.in_mm ? nb::cast(one.in_mm->axes.moments_mm2[i]) : nb::none();
  }
  for (std::size_t i = 0; i < 3; ++i) {
    set_axes(row, "principal_axis_" + std::to_string(i + 1) + "_", "",
             in_mm([&](const RegionInMm& mm) { return mm.axes.axes[i]; }));
  }
  if (!region.grey) return row;
  row["mean"] = region.grey->mean;
  row["sd"] = region.grey->deviation;
  row["min"] = region.grey->minimum;
  row["max"] = region.grey->maximum;
  row["integrated_mm3"] = one.in_mm && one.in_mm->integrated ? nb::cast(*one.in_mm->integrated)
                                                             : nb::none();
  for (std::size_t i = 0; i < result.percentiles.size(); ++i) {
    row[("p" + number_text(result.percentiles[i])).c_str()] = region.grey->percentiles[i];
  }
  return row;
}

nb::list measure_file(const OpenFile& labels, const std::string& name, const OpenFile* grey,
                      const std::string& grey_name, const std::vector<double>& percentiles,
                      const std::vector<std::int64_t>& numbers,
                      const std::vector<std::string>& names, const nb::dict& given) {
  MeasureOptions options{.labels = name,
                         .grey = grey == nullptr ? "" : grey_name,
                         .percentiles = percentiles,
                         .asked = {numbers, names}};
  std::vector<NamedFile> files = {{name, &labels}};
  if (grey != nullptr) files.push_back({grey_name, grey});
  Work work(given);
  const MeasureResult result = work.run(files, [&] { return measure(options, work.context()); });
  nb::list rows;
  for (const MeasuredRegion& one : result.regions) rows.append(region_row(one, result));
  return rows;
}

nb::dict compare_files(const OpenFile& a, const OpenFile& b, double max_error,
                       const nb::dict& given) {
  Work work(given);
  const TaskContext& context = work.context();
  const Comparison found = work.run({{"a", &a}, {"b", &b}}, [&] {
    if (const auto stated = compare_digests(a.reader(), b.reader())) return *stated;
    FilePlanes planes_a(a.shared_reader(), 0, context.thread_count());
    FilePlanes planes_b(b.shared_reader(), 0, context.thread_count());
    const std::uint64_t decoding = std::max(decoding_bytes(planes_a.description(), context),
                                            decoding_bytes(planes_b.description(), context));
    return compare_sources(planes_a, planes_b, max_error, decoding, context);
  });
  nb::dict row;
  row["equal"] = found.is_equal();
  row["same_stored"] = found.is_same_stored();
  row["same_shape"] = found.is_same_size;
  row["same_dtype"] = found.is_same_type;
  row["same_rescale"] = found.is_same_rescale;
  row["same_place"] = found.is_same_place;
  row["geometry_known"] = found.is_place_known;
  row["shift_mm"] = found.is_place_known ? nb::cast(found.shift_mm) : nb::none();
  row["different_voxels"] = found.different;
  row["nan_in_one"] = found.nan_in_one;
  row["max_difference"] = found.max_real_difference;
  if (found.different > 0) {
    row["first_different"] = nb::make_tuple(found.first.z, found.first.y, found.first.x);
  } else {
    row["first_different"] = nb::none();
  }
  return row;
}

void require_one_grid(const OpenFile& a, const std::string& a_name, const OpenFile& b,
                      const std::string& b_name) {
  require_same_grid(a.reader().description(), a_name, b.reader().description(), b_name, "grid");
}

}  // namespace

void bind_measuring(nb::module_& module) {
  module.def("measure", &measure_file, "labels"_a, "name"_a, "grey"_a.none(), "grey_name"_a,
             "percentiles"_a, "numbers"_a, "names"_a, "work"_a);
  module.def("compare", &compare_files, "a"_a, "b"_a, "max_error"_a, "work"_a);
  module.def("require_same_grid", &require_one_grid, "a"_a, "a_name"_a, "b"_a, "b_name"_a);
}

}  // namespace octavo::python
