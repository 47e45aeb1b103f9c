#include "structure.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <vector>

#include "octavo/tasks/distance.h"
#include "octavo/tasks/structure/align.h"
#include "octavo/tasks/structure/morphometry.h"
#include "octavo/tasks/structure/morphometry_rows.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::dict distance_file(const OpenFile& file, const std::string& name, const std::string& path,
                       const nb::dict& asked, const nb::dict& given) {
  DistanceOptions options;
  options.input = name;
  options.output = {path, nb::cast<bool>(asked["overwrite"])};
  options.to = nb::cast<std::string>(asked["to"]) == "centers" ? DistanceTo::centers
                                                               : DistanceTo::faces;
  options.max_mm = nb::cast<std::optional<double>>(asked["max_mm"]);
  options.is_in_steps = nb::cast<bool>(asked["steps"]);
  options.step_mm = nb::cast<std::optional<double>>(asked["step_mm"]);
  Work work(given);
  const DistanceResult result =
      work.run({{name, &file}}, [&] { return distance(options, work.context()); });
  nb::dict facts;
  facts["smallest_mm"] = result.smallest_mm;
  facts["largest_mm"] = result.largest_mm;
  return facts;
}

nb::object thickness_facts(const std::optional<ThicknessSummary>& summary) {
  if (!summary) return nb::none();
  nb::dict facts;
  facts["voxels"] = summary->voxels;
  facts["mean_mm"] = summary->mean_mm;
  facts["sd_mm"] = summary->deviation_mm;
  facts["min_mm"] = summary->minimum_mm;
  facts["max_mm"] = summary->maximum_mm;
  facts["bin_mm"] = summary->bin_mm;
  facts["bins"] = summary->bins;
  return facts;
}

nb::list slice_facts(const MorphometryResult& result) {
  const Point3& spacing = result.volume.geometry.spacing_mm;
  const double pixel_mm2 = spacing[0] * spacing[1];
  nb::list slices;
  for (const SliceMeasure& slice : result.slices) {
    nb::dict one;
    one["area_mm2"] = static_cast<double>(slice.voxels) * pixel_mm2;
    one["total_mm2"] = static_cast<double>(slice.region_voxels) * pixel_mm2;
    one["thickness_mm"] = slice.mean_thickness_mm;
    slices.append(one);
  }
  return slices;
}

nb::dict morphometry_facts(const MorphometryResult& result, bool has_tortuosity) {
  nb::dict facts;
  for (const MorphometryRow& row : morphometry_rows(result, has_tortuosity)) {
    facts[row.key.c_str()] = row.value ? nb::cast(*row.value) : nb::none();
  }
  facts["thickness"] = thickness_facts(result.thickness);
  facts["spacing"] = thickness_facts(result.spacing);
  facts["ellipsoids"] = nb::none();
  if (result.ellipsoids) {
    nb::dict ellipsoids;
    ellipsoids["count"] = result.ellipsoids->ellipsoids;
    ellipsoids["shares"] = result.ellipsoids->shares;
    facts["ellipsoids"] = ellipsoids;
  }
  facts["mil"] = nb::none();
  if (result.anisotropy) {
    nb::dict mil;
    mil["lengths_mm"] = result.anisotropy->lengths_mm;
    mil["axes"] = result.anisotropy->axes;
    facts["mil"] = mil;
  }
  nb::list boxes;
  for (const BoxCount& one : result.boxes) {
    nb::dict box;
    box["side"] = one.side;
    box["holding"] = one.holding;
    box["mixed"] = one.mixed;
    boxes.append(box);
  }
  facts["boxes"] = boxes;
  facts["touches_border"] = result.touches;
  facts["slices"] = slice_facts(result);
  return facts;
}

/// files  of the mask, then of the region and of the scan where `asked` names them
nb::dict morphometry_file(const std::vector<const OpenFile*>& files, const nb::dict& asked,
                          const nb::dict& given) {
  const auto text = [&](const char* name) { return nb::cast<std::string>(asked[name]); };
  MorphometryOptions options;
  options.input = text("mask");
  options.region = text("region");
  options.grey = text("grey");
  const auto line = nb::cast<std::array<double, 2>>(asked["calibration"]);
  options.calibration = {line[0], line[1]};
  options.has_thickness = nb::cast<bool>(asked["thickness"]);
  options.has_tortuosity = nb::cast<bool>(asked["tortuosity"]);
  const bool overwrites = nb::cast<bool>(asked["overwrite"]);
  options.thickness_map = {text("thickness_map"), overwrites};
  options.spacing_map = {text("spacing_map"), overwrites};
  std::vector<NamedFile> named;
  for (const std::string& name : {options.input, options.region, options.grey}) {
    if (!name.empty()) named.push_back({name, files[named.size()]});
  }
  Work work(given);
  return morphometry_facts(
      work.run(named, [&] { return morphometry(options, work.context()); }),
      options.has_tortuosity);
}

nb::dict align_files(const OpenFile& moving, const std::string& moving_name,
                     const OpenFile& fixed, const std::string& fixed_name, bool has_scale,
                     const nb::dict& given) {
  const AlignOptions options{moving_name, fixed_name, {}, has_scale};
  Work work(given);
  const AlignResult result =
      work.run({{moving_name, &moving}, {fixed_name, &fixed}},
               [&] { return align(options, work.context()); });
  const FoundPose& pose = result.pose;
  nb::dict facts;
  facts["found"] = result.is_found;
  nb::list rows;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* const linear = &pose.map.linear[3 * row];
    rows.append(nb::make_tuple(linear[0], linear[1], linear[2], pose.map.offset[row]));
  }
  facts["matrix_mm"] = rows;
  facts["scale"] = pose.scale;
  facts["agreement"] = result.agreement.forward;
  facts["agreement_around"] = result.agreement.backward;
  facts["overlap"] = pose.overlap;
  facts["mean_mm"] = pose.mean_mm;
  facts["p95_mm"] = pose.p95_mm;
  facts["max_mm"] = pose.max_mm;
  facts["iterations"] = pose.iterations;
  facts["condition"] = pose.condition;
  facts["points"] = result.points;
  facts["level"] = result.level;
  return facts;
}

}  // namespace

void bind_structure(nb::module_& module) {
  module.def("distance", &distance_file, "file"_a, "name"_a, "path"_a, "asked"_a, "work"_a);
  module.def("morphometry", &morphometry_file, "files"_a, "asked"_a, "work"_a);
  module.def("align", &align_files, "moving"_a, "moving_name"_a, "fixed"_a, "fixed_name"_a,
             "has_scale"_a, "work"_a);
}

}  // namespace octavo::python
