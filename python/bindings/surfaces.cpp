#include "surfaces.h"

#include <nanobind/ndarray.h>
#include <nanobind/stl/array.h>
#include <nanobind/stl/pair.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "asked.h"
#include "facts.h"
#include "octavo/core/error.h"
#include "octavo/mesh/formats/mesh_bytes.h"
#include "octavo/tasks/hexahedra.h"
#include "octavo/tasks/surface.h"
#include "octavo/tasks/surfaces/label_surfaces.h"
#include "octavo/tasks/surfaces/surface_mesh.h"

namespace octavo::python {

namespace nb = nanobind;
using namespace nb::literals;

namespace {

/// What surfaces of all kinds are asked: labels, level, how many triangles, the space.
template <class Options>
void set_surface(const nb::dict& asked, Options& options) {
  options.labels = asked_labels(asked);
  options.level = asked_for<int>(asked, "level");
  const auto [deviation, is_in_voxels] =
      asked_for<std::pair<double, bool>>(asked, "max_deviation");
  options.max_deviation = {deviation, is_in_voxels};
  if (const auto most =
          asked_for<std::optional<std::pair<double, bool>>>(asked, "triangles")) {
    options.triangles = AskedTriangles{most->first, most->second};
  }
  options.space = asked_word<MeshSpace>(asked, "space");
}

SurfaceOptions surface_options(const std::string& name, const nb::dict& asked) {
  SurfaceOptions options;
  options.input = name;
  set_surface(asked, options);
  options.isovalue = asked_for<std::optional<double>>(asked, "isovalue");
  options.is_stored = asked_for<bool>(asked, "stored");
  if (const auto seed = asked_for<std::optional<std::array<double, 3>>>(asked, "seed")) {
    options.seed = xyz_of(*seed);
  }
  options.method = asked_word<DecimationMethod>(asked, "method");
  options.allows_faults = asked_for<bool>(asked, "allow_faults");
  return options;
}

/// What surfaces of all kinds say of themselves: checks and measures.
template <class Surface>
Facts checked_facts(const Surface& surface, const Facts& others) {
  Facts facts = {{"closed", surface.check.is_closed()},
                 {"manifold", surface.check.is_manifold()},
                 {"components", surface.check.components},
                 {"area_mm2", surface.measures.area_mm2},
                 {"volume_mm3", surface.measures.volume_mm3}};
  facts.insert(facts.end(), others.begin(), others.end());
  return facts;
}

nb::dict surface_facts(const SurfaceResult& result) {
  return dict_of(checked_facts(result, {{"max_deviation_mm", result.max_deviation_mm},
                                        {"full_triangles", result.full_triangle_count},
                                        {"crossing_triangles", result.crossing_triangles}}));
}

/// An array of rows of three, which keeps what it is of alive.
template <class T, class Row>
nb::object rows_of_three(std::vector<Row> rows) {
  auto* const held = new std::vector<Row>(std::move(rows));
  const nb::capsule owner(held,
                          [](void* p) noexcept { delete static_cast<std::vector<Row>*>(p); });
  T* const first = held->empty() ? nullptr : held->front().data();
  return nb::cast(nb::ndarray<nb::numpy, T, nb::shape<-1, 3>>(first, {held->size(), 3}, owner));
}

/// (points x y z in mm, triangles, facts)
nb::tuple surface_arrays(const OpenFile& file, const std::string& name, const nb::dict& asked,
                         const nb::dict& given) {
  const SurfaceOptions options = surface_options(name, asked);
  Work work(given);
  SurfaceMesh made = work.run({{name, &file}}, [&] {
    return surface_mesh(file.reader(), options, false, work.context());
  });
  for (MeshPoint& point : made.mesh.points) point = in_space(point, options.space);
  return nb::make_tuple(rows_of_three<float>(std::move(made.mesh.points)),
                        rows_of_three<std::uint32_t>(std::move(made.mesh.triangles)),
                        surface_facts(made.result));
}

nb::dict surface_file(const OpenFile& file, const std::string& name, const std::string& path,
                      bool overwrite, const nb::dict& asked, const nb::dict& given) {
  SurfaceOptions options = surface_options(name, asked);
  options.output = {path, overwrite};
  options.report_path = asked_for<std::string>(asked, "report");
  options.is_plain = asked_for<bool>(asked, "plain");
  const SurfaceResult result = run_task(surface, options, {{name, &file}}, given);
  if (!result.is_written) {
    throw Error(ErrorKind::invalid_argument,
                "the surface is not closed or not manifold, and nothing was written", name)
        .with_field("allows_faults");
  }
  nb::dict facts = surface_facts(result);
  facts["points"] = result.point_count;
  facts["triangles"] = result.triangle_count;
  facts["file_bytes"] = result.file_bytes;
  return facts;
}

Facts label_surface_facts(const LabelSurface& surface) {
  return checked_facts(
      surface, {{"label", surface.label},
                {"path", surface.path.empty() ? FactValue() : FactValue(surface.path)},
                {"points", surface.point_count},
                {"triangles", surface.triangle_count},
                {"touching_points", surface.touching_points},
                {"voxels", surface.voxel_count},
                {"volume_change", surface.volume_change},
                {"longest_move_mm", surface.longest_move_mm}});
}

nb::dict label_surface_files(const OpenFile& file, const std::string& name,
                             const std::string& path, bool overwrite, const nb::dict& asked,
                             const nb::dict& given) {
  LabelSurfacesOptions options;
  options.input = name;
  options.output = {path, overwrite};
  set_surface(asked, options);
  options.form = asked_word<LabelSurfaceForm>(asked, "form");
  options.part_format = asked_word<MeshFormat>(asked, "part_format");
  options.smoothing_steps = asked_for<int>(asked, "smooth");
  const LabelSurfacesResult result = run_task(label_surfaces, options, {{name, &file}}, given);
  if (!result.is_written) {
    throw Error(ErrorKind::invalid_argument,
                "a surface is not closed or not manifold, and nothing was written", name);
  }
  return dict_of({{"points", result.point_count},
                  {"triangles", result.triangle_count},
                  {"full_triangles", result.full_triangle_count},
                  {"max_deviation_mm", result.max_deviation_mm},
                  {"crossing_triangles", result.crossing_triangles},
                  {"pairs", result.pair_count},
                  {"file_bytes", result.file_bytes},
                  {"labels", list_of_facts(result.labels, label_surface_facts)}});
}

nb::dict hexahedra_facts(const HexahedraResult& result) {
  return dict_of({{"elements", result.element_count},
                  {"elements_of_shape", result.elements_of_shape},
                  {"nodes", result.node_count},
                  {"hanging_nodes", result.hanging_count},
                  {"parts", result.part_count},
                  {"voxels", result.voxel_count},
                  {"cells_of_level", result.cells_of_level},
                  {"labels", result.labels},
                  {"materials", result.material_count},
                  {"modulus_range_mpa", result.modulus_range_mpa},
                  {"volume_mm3", result.volume_mm3},
                  {"quality", facts_if(result.quality, quality_facts)},
                  {"file_bytes", result.file_bytes}});
}

/// others  (name, file) of the grey values under it
nb::dict hexahedra_file(const OpenFile& file, const std::string& name, const std::string& path,
                        const nb::list& others, const nb::dict& asked, const nb::dict& given) {
  HexahedraOptions options;
  options.input = name;
  options.output = {path, asked_for<bool>(asked, "overwrite")};
  options.method = asked_word<HexMethod>(asked, "method");
  options.labels = asked_labels(asked);
  options.level = asked_for<int>(asked, "level");
  options.keep_largest = asked_for<bool>(asked, "keep_largest");
  const std::vector<NamedFile> files = named_files(file, name, others);
  if (files.size() > 1) options.grey = files.back().name;
  using Two = std::optional<std::pair<double, double>>;
  if (const auto line = asked_for<Two>(asked, "density")) {
    options.density = DensityLine{line->first, line->second};
  }
  if (const auto power = asked_for<Two>(asked, "modulus")) {
    options.modulus =
        ModulusPower{power->first, power->second, asked_for<double>(asked, "min_modulus")};
  }
  options.poisson_ratio = asked_for<double>(asked, "poisson_ratio");
  options.bin_count = asked_for<int>(asked, "bins");
  options.has_quality = asked_for<bool>(asked, "quality");
  return hexahedra_facts(run_task(hexahedra, options, files, given));
}

}  // namespace

void bind_surfaces(nb::module_& module) {
  module.def("surface", &surface_arrays, "file"_a, "name"_a, "asked"_a, "work"_a);
  module.def("save_surface", &surface_file, "file"_a, "name"_a, "path"_a, "overwrite"_a,
             "asked"_a, "work"_a);
  module.def("save_label_surfaces", &label_surface_files, "file"_a, "name"_a, "path"_a,
             "overwrite"_a, "asked"_a, "work"_a);
  module.def("save_hexahedra", &hexahedra_file, "file"_a, "name"_a, "path"_a, "others"_a,
             "asked"_a, "work"_a);
}

}  // namespace octavo::python
