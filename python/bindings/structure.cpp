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
  options.to = asked_word<DistanceTo>(asked, "to");
  options.max_mm = asked_for<std::optional<double>>(asked, "max_mm");
  options.is_in_steps = asked_for<bool>(asked, "steps");
  options.step_mm = asked_for<std::optional<double>>(asked, "step_mm");
  options.within_mm = asked_for<std::optional<double>>(asked, "within_mm");
  const DistanceResult result = run_task(distance, options, {{name, &file}}, given);
  return dict_of({{"smallest_mm", result.smallest_mm}, {"largest_mm", result.largest_mm}});
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
  const MorphometryResult result = run_task(morphometry, options, named, given);
  Facts facts = morphometry_facts(result, options.has_tortuosity);
  facts.push_back({"slices", slice_facts(result)});
  return dict_of(facts);
}

/// moving  null where `moving` of `asked` is a file of a mesh, points or lines
nb::dict align_files(const OpenFile* moving, const OpenFile& fixed, const nb::dict& asked,
                     const nb::dict& given) {
  const auto text = [&](const char* name) { return asked_for<std::string>(asked, name); };
  const bool overwrites = asked_for<bool>(asked, "overwrite");
  const AlignOptions options{text("moving"), text("fixed"), {text("output"), overwrites},
                             asked_for<bool>(asked, "scale"), {text("picture"), overwrites}};
  return dict_of(pose_facts(
      run_task(align, options, {{options.fixed, &fixed}, {options.moving, moving}}, given)));
}

/// Cubes that equal others.
nb::dict self_similarity_of(const OpenFile& file, const std::string& name, const OpenFile* coded,
                            const std::string& coded_name, double max_difference,
                            bool is_up_to_mean, const nb::dict& given) {
  const SelfSimilarityOptions options{name, max_difference, is_up_to_mean,
                                      coded == nullptr ? "" : coded_name};
  const SelfSimilarityResult result =
      run_task(self_similarity, options, {{name, &file}, {coded_name, coded}}, given);
  return dict_of({{"file_bytes", result.file_bytes},
                  {"saved_bytes", result.saved_bytes()},
                  {"levels", list_of_facts(result.levels, similarity_facts)}});
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
  const TouchMasksResult result =
      run_task(touch_masks, options, {{a_name, &a}, {b_name, &b}}, given);
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
  const TouchLabelsResult result = run_task(touch_labels, options, {{name, &file}}, given);
  return list_of(result.contacts, [&](const LabelContact& contact) {
    return dict_of({{"first", contact.first},
                    {"second", contact.second},
                    {"voxel_pairs", contact.voxel_pairs},
                    {"area_mm2", area_mm2(contact.face_pairs, result.volume)}});
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
