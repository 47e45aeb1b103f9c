#include "structure.h"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>
#include <string>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/tasks/distance.h"
#include "octavo/tasks/structure/align.h"
#include "octavo/tasks/structure/morphometry.h"
#include "octavo/tasks/structure/morphometry_rows.h"
#include "octavo/tasks/structure/self_similarity.h"
#include "octavo/tasks/touch.h"
#include "work.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

nb::dict distance_file(const OpenFile& file, const std::string& name, const std::string& path,
                       const nb::dict& asked, const nb::dict& given) {
  DistanceOptions options;
  options.input = name;
  options.output = {path, asked_for<bool>(asked, "overwrite")};
  options.to = asked_for<std::string>(asked, "to") == "centers" ? DistanceTo::centers
                                                               : DistanceTo::faces;
  options.max_mm = asked_for<std::optional<double>>(asked, "max_mm");
  options.is_in_steps = asked_for<bool>(asked, "steps");
  options.step_mm = asked_for<std::optional<double>>(asked, "step_mm");
  options.within_mm = asked_for<std::optional<double>>(asked, "within_mm");
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
  return list_of(result.slices, [&](const SliceMeasure& slice) {
    nb::dict one;
    one["area_mm2"] = static_cast<double>(slice.voxels) * pixel_mm2;
    one["total_mm2"] = static_cast<double>(slice.region_voxels) * pixel_mm2;
    one["thickness_mm"] = slice.mean_thickness_mm;
    return one;
  });
}

nb::dict box_facts(const BoxCount& one) {
  nb::dict box;
  box["side"] = one.side;
  box["holding"] = one.holding;
  box["mixed"] = one.mixed;
  return box;
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
    nb::list lengths;
    for (const double mm : result.anisotropy->lengths_mm) {  // 0: without end
      lengths.append(mm > 0 ? nb::cast(mm) : nb::none());
    }
    mil["lengths_mm"] = lengths;
    mil["axes"] = result.anisotropy->axes;
    facts["mil"] = mil;
  }
  facts["boxes"] = list_of(result.boxes, box_facts);
  facts["touches_border"] = result.touches;
  facts["slices"] = slice_facts(result);
  return facts;
}

/// files  of the mask, then of the region and of the scan where `asked` names them
nb::dict morphometry_file(const std::vector<const OpenFile*>& files, const nb::dict& asked,
                          const nb::dict& given) {
  const auto text = [&](const char* name) { return asked_for<std::string>(asked, name); };
  MorphometryOptions options;
  options.input = text("mask");
  options.region = text("region");
  options.grey = text("grey");
  const auto line = asked_for<std::array<double, 2>>(asked, "calibration");
  options.calibration = {line[0], line[1]};
  options.has_thickness = asked_for<bool>(asked, "thickness");
  options.has_tortuosity = asked_for<bool>(asked, "tortuosity");
  options.has_diffusion = asked_for<bool>(asked, "diffusion");
  const bool overwrites = asked_for<bool>(asked, "overwrite");
  options.thickness_map = {text("thickness_map"), overwrites};
  options.spacing_map = {text("spacing_map"), overwrites};
  options.histogram = {text("histogram"), overwrites};
  std::vector<NamedFile> named;
  for (const std::string& name : {options.input, options.region, options.grey}) {
    if (!name.empty()) named.push_back({name, files[named.size()]});
  }
  Work work(given);
  return morphometry_facts(
      work.run(named, [&] { return morphometry(options, work.context()); }),
      options.has_tortuosity);
}

nb::dict pose_facts(const AlignResult& result) {
  const FoundPose& pose = result.pose;
  nb::dict facts;
  facts["found"] = result.is_found;
  facts["why_none"] = result.is_found ? nb::none() : nb::object(nb::cast(result.why_none));
  nb::list rows;
  for (std::size_t row = 0; row < 3; ++row) {
    const double* const linear = &pose.map.linear[3 * row];
    rows.append(nb::make_tuple(linear[0], linear[1], linear[2], pose.map.offset[row]));
  }
  facts["matrix_mm"] = rows;
  facts["scale"] = pose.scale;
  facts["agreement"] = result.agreement.forward;
  facts["agreement_around"] = result.agreement.backward;
  facts["sharpness"] = result.agreement.sharpness;
  facts["parting"] = result.agreement.parting;
  facts["doubtful"] = result.is_doubtful;
  facts["overlap"] = pose.overlap;
  facts["mean_mm"] = pose.mean_mm;
  facts["p95_mm"] = pose.p95_mm;
  facts["max_mm"] = pose.max_mm;
  facts["iterations"] = pose.iterations;
  facts["condition"] = pose.condition;
  facts["points"] = result.points;
  facts["has_lines"] = result.has_lines;
  facts["level"] = result.level;
  return facts;
}

/// moving  null where `moving` of `asked` is a file of a mesh, points or lines
nb::dict align_files(const OpenFile* moving, const OpenFile& fixed, const nb::dict& asked,
                     const nb::dict& given) {
  const auto text = [&](const char* name) { return asked_for<std::string>(asked, name); };
  const bool overwrites = asked_for<bool>(asked, "overwrite");
  const AlignOptions options{text("moving"), text("fixed"), {text("output"), overwrites},
                             asked_for<bool>(asked, "scale"), {text("picture"), overwrites}};
  std::vector<NamedFile> files = {{options.fixed, &fixed}};
  if (moving != nullptr) files.push_back({options.moving, moving});
  Work work(given);
  return pose_facts(work.run(files, [&] { return align(options, work.context()); }));
}

nb::dict similarity_facts(const SimilarityLevel& level) {
  nb::dict one;
  one["side"] = level.side;
  one["cubes"] = level.cubes;
  one["uniform"] = level.uniform;
  one["asked"] = level.asked;
  one["same_level"] = level.same_level;
  one["next_level"] = level.next_level;
  one["turned"] = level.turned;
  one["cut_short"] = level.cut_short;
  one["coded_bytes"] = level.coded_bytes;
  one["reference_bytes"] = level.reference_bytes;
  return one;
}

/// Cubes that equal others.
nb::dict self_similarity_of(const OpenFile& file, const std::string& name, const OpenFile* coded,
                            const std::string& coded_name, double max_difference,
                            bool is_up_to_mean, const nb::dict& given) {
  const SelfSimilarityOptions options{name, max_difference, is_up_to_mean,
                                      coded == nullptr ? "" : coded_name};
  std::vector<NamedFile> files = {{name, &file}};
  if (coded != nullptr) files.push_back({coded_name, coded});
  Work work(given);
  const SelfSimilarityResult result =
      work.run(files, [&] { return self_similarity(options, work.context()); });
  nb::dict facts;
  facts["file_bytes"] = result.file_bytes;
  facts["saved_bytes"] = result.saved_bytes();
  facts["levels"] = list_of(result.levels, similarity_facts);
  return facts;
}

nb::dict extent_facts(const VoxelExtent& extent) {
  nb::dict facts;
  facts["voxels"] = extent.voxel_count;
  facts["box"] = nb::none();
  if (extent.voxel_count > 0) {
    facts["box"] = nb::make_tuple(zyx_of(extent.box.lo), zyx_of(extent.box.hi));
  }
  return facts;
}

/// How two masks meet.
nb::dict touch_of(const OpenFile& a, const std::string& a_name, const OpenFile& b,
                  const std::string& b_name, int connectivity, const nb::dict& given) {
  const TouchMasksOptions options{a_name, b_name, static_cast<Connectivity>(connectivity)};
  Work work(given);
  const TouchMasksResult result = work.run({{a_name, &a}, {b_name, &b}},
                                           [&] { return touch_masks(options, work.context()); });
  nb::dict facts;
  facts["overlap"] = extent_facts(result.found.overlap);
  facts["contact"] = extent_facts(result.found.contact_a);
  facts["contact_of_other"] = extent_facts(result.found.contact_b);
  facts["area_mm2"] = area_mm2(result.found.face_pairs, result.volume);
  return facts;
}

/// The labels that lie side by side.
nb::list contacts_of(const OpenFile& file, const std::string& name, int connectivity,
                     const nb::dict& given) {
  const TouchLabelsOptions options{name, static_cast<Connectivity>(connectivity)};
  Work work(given);
  const TouchLabelsResult result =
      work.run({{name, &file}}, [&] { return touch_labels(options, work.context()); });
  return list_of(result.contacts, [&](const LabelContact& contact) {
    nb::dict row;
    row["first"] = contact.first;
    row["second"] = contact.second;
    row["voxel_pairs"] = contact.voxel_pairs;
    row["area_mm2"] = area_mm2(contact.face_pairs, result.volume);
    return row;
  });
}

}  // namespace

void bind_structure(nb::module_& module) {
  module.def("distance", &distance_file, "file"_a, "name"_a, "path"_a, "asked"_a, "work"_a);
  module.def("morphometry", &morphometry_file, "files"_a, "asked"_a, "work"_a);
  module.def("align", &align_files, "moving"_a.none(), "fixed"_a, "asked"_a, "work"_a);
  module.def("self_similarity", &self_similarity_of, "file"_a, "name"_a, "coded"_a.none(),
             "coded_name"_a, "max_difference"_a, "is_up_to_mean"_a, "work"_a);
  module.def("touch", &touch_of, "a"_a, "a_name"_a, "b"_a, "b_name"_a, "connectivity"_a,
             "work"_a);
  module.def("contacts", &contacts_of, "file"_a, "name"_a, "connectivity"_a, "work"_a);
}

}  // namespace octavo::python
