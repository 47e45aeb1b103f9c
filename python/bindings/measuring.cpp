#include "measuring.h"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <string>
#include <vector>

#include "facts.h"
#include "octavo/tasks/file_planes.h"
#include "octavo/tasks/files/decoding_memory.h"
#include "octavo/tasks/files/plane_compare.h"
#include "octavo/tasks/masks.h"
#include "octavo/tasks/measure.h"
#include "octavo/tasks/structure/region_rows.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::list measure_file(const OpenFile& labels, const std::string& name, const OpenFile* grey,
                      const std::string& grey_name, const std::vector<double>& percentiles,
                      const std::vector<std::int64_t>& numbers,
                      const std::vector<std::string>& names, const nb::dict& given) {
  const MeasureOptions options{.labels = name,
                               .grey = grey == nullptr ? "" : grey_name,
                               .percentiles = percentiles,
                               .asked = {numbers, names}};
  const MeasureResult result =
      run_task(measure, options, {{name, &labels}, {grey_name, grey}}, given);
  return list_of(result.regions, [&](const MeasuredRegion& one) {
    return dict_of(columns_of(region_row(one, result)));
  });
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
