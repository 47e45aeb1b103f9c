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
  options.space = asked_for<std::string>(asked, "space") == "ras" ? MeshSpace::ras
                                                                   : MeshSpace::lps;
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
  if (asked_for<std::string>(asked, "method") == "octree") {
    options.method = DecimationMethod::cells;
  }
  options.allows_faults = asked_for<bool>(asked, "allow_faults");
  return options;
}

/// What surfaces of all kinds say of themselves: checks and measures.
template <class Surface>
nb::dict checked_facts(const Surface& surface) {
  nb::dict facts;
  facts["closed"] = surface.check.is_closed();
  facts["manifold"] = surface.check.is_manifold();
  facts["components"] = surface.check.components;
  facts["area_mm2"] = surface.measures.area_mm2;
  facts["volume_mm3"] = surface.measures.volume_mm3;
  return facts;
}

nb::dict surface_facts(const SurfaceResult& result) {
  nb::dict facts = checked_facts(result);
  facts["max_deviation_mm"] = result.max_deviation_mm;
  facts["full_triangles"] = result.full_triangle_count;
  facts["crossing_triangles"] = result.crossing_triangles;
  return facts;
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
  Work work(given);
  const SurfaceResult result =
      work.run({{name, &file}}, [&] { return surface(options, work.context()); });
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

nb::dict label_surface_facts(const LabelSurface& surface) {
  nb::dict facts = checked_facts(surface);
  facts["label"] = surface.label;
  facts["path"] = surface.path.empty() ? nb::none() : nb::cast(surface.path);
  facts["points"] = surface.point_count;
  facts["triangles"] = surface.triangle_count;
  facts["touching_points"] = surface.touching_points;
  facts["voxels"] = surface.voxel_count;
  facts["volume_change"] = surface.volume_change;
  facts["longest_move_mm"] = surface.longest_move_mm;
  return facts;
}

nb::dict label_surface_files(const OpenFile& file, const std::string& name,
                             const std::string& path, bool overwrite, const nb::dict& asked,
                             const nb::dict& given) {
  LabelSurfacesOptions options;
  options.input = name;
  options.output = {path, overwrite};
  set_surface(asked, options);
  if (asked_for<std::string>(asked, "form") == "interfaces") {
    options.form = LabelSurfaceForm::interfaces;
  }
  const auto format = mesh_format_of("part." + asked_for<std::string>(asked, "part_format"));
  if (!format) {
    throw Error(ErrorKind::invalid_argument,
                "part_format is stl, ply, obj, glb, vtp or 3mf");
  }
  options.part_format = *format;
  options.smoothing_steps = asked_for<int>(asked, "smooth");
  Work work(given);
  const LabelSurfacesResult result =
      work.run({{name, &file}}, [&] { return label_surfaces(options, work.context()); });
  if (!result.is_written) {
    throw Error(ErrorKind::invalid_argument,
                "a surface is not closed or not manifold, and nothing was written", name);
  }
  nb::dict facts;
  facts["points"] = result.point_count;
  facts["triangles"] = result.triangle_count;
  facts["full_triangles"] = result.full_triangle_count;
  facts["max_deviation_mm"] = result.max_deviation_mm;
  facts["crossing_triangles"] = result.crossing_triangles;
  facts["pairs"] = result.pair_count;
  facts["file_bytes"] = result.file_bytes;
  facts["labels"] = list_of(result.labels, label_surface_facts);
  return facts;
}

nb::object quality_facts(const std::optional<HexQuality>& quality) {
  if (!quality) return nb::none();
  nb::dict shares;
  for (const auto& [name, percent] :
       {std::pair{"min", 0}, {"p1", 1}, {"p5", 5}, {"p50", 50}, {"max", 100}}) {
    shares[name] = quality->percentile(percent);
  }
  nb::dict facts;
  facts["scaled_jacobian"] = shares;
  facts["min_volume_mm3"] = quality->min_volume_mm3;
  facts["max_volume_mm3"] = quality->max_volume_mm3;
  facts["total_volume_mm3"] = quality->total_volume_mm3;
  return facts;
}

nb::dict hexahedra_facts(const HexahedraResult& result) {
  nb::dict facts;
  facts["elements"] = result.element_count;
  facts["elements_of_shape"] = result.elements_of_shape;
  facts["nodes"] = result.node_count;
  facts["hanging_nodes"] = result.hanging_count;
  facts["parts"] = result.part_count;
  facts["voxels"] = result.voxel_count;
  facts["cells_of_level"] = result.cells_of_level;
  facts["labels"] = result.labels;
  facts["materials"] = result.material_count;
  facts["modulus_range_mpa"] = result.modulus_range_mpa;
  facts["volume_mm3"] = result.volume_mm3;
  facts["quality"] = quality_facts(result.quality);
  facts["file_bytes"] = result.file_bytes;
  return facts;
}

/// others  (name, file) of the grey values under it
nb::dict hexahedra_file(const OpenFile& file, const std::string& name, const std::string& path,
                        const nb::list& others, const nb::dict& asked, const nb::dict& given) {
  HexahedraOptions options;
  options.input = name;
  options.output = {path, asked_for<bool>(asked, "overwrite")};
  const auto method = asked_for<std::string>(asked, "method");
  options.method = method == "octree"       ? HexMethod::octree
                   : method == "conforming" ? HexMethod::conforming
                                            : HexMethod::uniform;
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
  Work work(given);
  return hexahedra_facts(
      work.run(files, [&] { return hexahedra(options, work.context()); }));
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
