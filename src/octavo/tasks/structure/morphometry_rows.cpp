#include "octavo/tasks/structure/morphometry_rows.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

namespace octavo {

namespace {

/// A number in mm that is there where `summary` is, and has voxels.
struct LengthRow {
  const char* key;
  const char* label;
  double ThicknessSummary::* value;
  const char* words;
};

void add_length_rows(const std::optional<ThicknessSummary>& summary,
                     std::span<const LengthRow> lengths, const char* missing_words,
                     std::vector<MorphometryRow>& rows) {
  for (const LengthRow& length : lengths) {
    const bool is_there = summary && summary->voxels > 0;
    rows.push_back({length.key, length.label,
                    is_there ? std::optional((*summary).*length.value) : std::nullopt, "mm",
                    is_there ? length.words : missing_words});
  }
}

constexpr const char* kNoSurface = "not measured: there is no surface";
constexpr const char* kNoPores = "not measured: nothing but the mask is there";

void add_thickness_rows(const MorphometryResult& result, std::vector<MorphometryRow>& rows) {
  if (!result.has_thickness) return;
  constexpr LengthRow kThickness[] = {
      {"tb_th_mm", "Tb.Th", &ThicknessSummary::mean_mm, "mean thickness"},
      {"tb_th_sd_mm", "Tb.Th.SD", &ThicknessSummary::deviation_mm, "its standard deviation"},
      {"tb_th_max_mm", "Tb.Th.max", &ThicknessSummary::maximum_mm, "largest thickness"}};
  constexpr LengthRow kSeparation[] = {
      {"tb_sp_mm", "Tb.Sp", &ThicknessSummary::mean_mm, "mean separation, size of pores"},
      {"tb_sp_sd_mm", "Tb.Sp.SD", &ThicknessSummary::deviation_mm, "its standard deviation"},
      {"tb_sp_max_mm", "Tb.Sp.max", &ThicknessSummary::maximum_mm, "largest separation"}};

  const auto& th = result.thickness;
  add_length_rows(th, kThickness, kNoSurface, rows);
  const std::optional<double> number =
      th && th->mean_mm > 0 ? std::optional(result.share() / th->mean_mm) : std::nullopt;
  rows.push_back({"tb_n_per_mm", "Tb.N", number, "1/mm",
                  number ? "number: BV/TV over Tb.Th" : kNoSurface});
  const auto& ellipsoids = result.ellipsoids;
  rows.push_back({"ellipsoid_factor", "EF",
                  ellipsoids ? std::optional(ellipsoids->mean) : std::nullopt, "",
                  ellipsoids ? "-1 plates, 0 neither, 1 rods" : kNoSurface});
  rows.push_back({"ellipsoid_factor_sd", "EF.SD",
                  ellipsoids ? std::optional(ellipsoids->deviation) : std::nullopt, "",
                  ellipsoids ? "its standard deviation" : kNoSurface});
  const auto& sp = result.spacing;
  add_length_rows(sp, kSeparation, kNoPores, rows);
  for (const int percent : {10, 50, 90}) {
    const bool is_there = sp && sp->voxels > 0;
    rows.push_back({fmt::format("pore_d{}_mm", percent), fmt::format("pore d{}", percent),
                    is_there ? std::optional(sp->quantile_mm(0.01 * percent)) : std::nullopt, "mm",
                    is_there ? fmt::format("{} % of the pore volume is narrower", percent)
                             : kNoPores});
  }
}

/// Why there is no way through the pores along an axis.
std::string no_way_words(const MorphometryResult& result, std::size_t axis) {
  return result.has_ends[axis] ? "no pore leads through" : "not measured: the region tapers";
}

void add_path_rows(const MorphometryResult& result, std::vector<MorphometryRow>& rows) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& path = result.paths[axis];
    const char name = "xyz"[axis];
    rows.push_back({fmt::format("tortuosity_{}", name), fmt::format("tau.{}", name),
                    path ? std::optional(path->tortuosity) : std::nullopt, "",
                    path ? fmt::format("geodesic tortuosity of pores; {:.0f} % of the far ones are "
                                       "reached",
                                       100 * path->reached_share)
                         : no_way_words(result, axis)});
  }
}

void add_diffusion_rows(const MorphometryResult& result, std::vector<MorphometryRow>& rows) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto& diffusion = result.diffusions[axis];
    const char name = "xyz"[axis];
    const std::string no_way = no_way_words(result, axis);
    // Nothing spreads through pores that do not lead through.
    const std::optional<double> blocked =
        result.has_ends[axis] ? std::optional(0.0) : std::nullopt;
    rows.push_back({fmt::format("effective_diffusivity_{}", name), fmt::format("Deff.{}", name),
                    diffusion ? std::optional(diffusion->effective) : blocked, "",
                    diffusion ? "effective diffusivity, 1 in free space" : no_way});
    rows.push_back({fmt::format("diffusive_tortuosity_{}", name), fmt::format("tau.D.{}", name),
                    diffusion ? std::optional(diffusion->tortuosity) : std::nullopt, "",
                    diffusion ? "diffusive tortuosity, porosity over Deff" : no_way});
  }
}

void add_form_rows(const MorphometryResult& result, std::vector<MorphometryRow>& rows) {
  const double spread = static_cast<double>(result.euler.faces - result.euler.corners);
  rows.push_back({"euler_number", "Euler", static_cast<double>(result.euler.corners), "",
                  "pieces - tunnels + cavities, voxels joined by corners"});
  rows.push_back({"euler_number_by_faces", "Euler.6", static_cast<double>(result.euler.faces), "",
                  "the same, voxels joined by faces"});
  rows.push_back({"euler_number_error", "Euler.err", std::abs(spread) / 2, "",
                  "half of how far the two are apart"});
  rows.push_back({"connectivity", "Conn", result.connectivity, "",
                  "1 - Euler number, the border of the volume weighted"});
  rows.push_back({"connectivity_density_per_mm3", "Conn.D",
                  result.connectivity / result.total_mm3, "1/mm3", "connectivity over TV"});
  const auto& a = result.anisotropy;
  rows.push_back({"degree_of_anisotropy", "DA", a ? std::optional(a->degree) : std::nullopt, "",
                  a ? "0 alike all round, 1 aligned" : kNoSurface});
  const bool is_bounded = a && a->lengths_mm[0] > 0 && a->lengths_mm[2] > 0;
  rows.push_back({"mil_ratio", "MIL ratio",
                  is_bounded ? std::optional(a->lengths_mm[0] / a->lengths_mm[2]) : std::nullopt,
                  "", a ? "longest over shortest mean intercept" : kNoSurface});
  const auto add_fractal = [&](const std::optional<FractalFit>& fit, const std::string& key,
                               const std::string& label, const char* words) {
    rows.push_back({key, label, fit ? std::optional(fit->dimension) : std::nullopt, "",
                    fit ? fmt::format("{}, boxes of {} to {} voxels", words, fit->smallest_side,
                                      fit->largest_side)
                        : "not measured: the region is too small, or no box meets it"});
    rows.push_back({key + "_r2", label + ".R2", fit ? std::optional(fit->r2) : std::nullopt, "",
                    "how well the line fits"});
  };
  add_fractal(result.fractal, "fractal_dimension", "FD", "fractal dimension");
  add_fractal(result.surface_fractal, "surface_fractal_dimension", "FD.S", "that of the surface");
}

Facts thickness_facts(const ThicknessSummary& summary) {
  return {{"voxels", summary.voxels},        {"mean_mm", summary.mean_mm},
          {"sd_mm", summary.deviation_mm},   {"min_mm", summary.minimum_mm},
          {"max_mm", summary.maximum_mm},    {"bin_mm", summary.bin_mm},
          {"bins", summary.bins}};
}

Facts ellipsoid_facts(const EllipsoidFactors& factors) {
  return {{"count", factors.ellipsoids}, {"shares", factors.shares}};
}

Facts intercept_facts(const Anisotropy& anisotropy) {
  FactValue::List lengths;
  for (const double mm : anisotropy.lengths_mm) {  // 0: without end
    lengths.push_back(mm > 0 ? std::optional(mm) : std::nullopt);
  }
  return {{"lengths_mm", lengths}, {"axes", anisotropy.axes}};
}

Facts box_facts(const BoxCount& boxes) {
  return {{"side", boxes.side}, {"holding", boxes.holding}, {"mixed", boxes.mixed}};
}

}  // namespace

std::vector<MorphometryRow> morphometry_rows(const MorphometryResult& result,
                                             bool has_tortuosity) {
  std::vector<MorphometryRow> rows = {
      {"bv_mm3", "BV", result.bone_mm3, "mm3", "volume of the mask"},
      {"tv_mm3", "TV", result.total_mm3, "mm3", "volume that is measured"},
      {"bv_tv", "BV/TV", result.share(), "", "share of the mask"},
      {"porosity", "Po", 1 - result.share(), "", "share of what is not in it"},
      {"bs_mm2", "BS", result.surface.area_mm2, "mm2", "surface between the two"},
      {"bs_bv_per_mm", "BS/BV", result.surface.area_mm2 / result.bone_mm3, "1/mm",
       "surface by volume of the mask"},
      {"bs_tv_per_mm", "BS/TV", result.surface.area_mm2 / result.total_mm3, "1/mm",
       "surface by volume that is measured"},
      {"cut_mm2", "cut", result.surface.cut_mm2, "mm2", "faces at the border, not in BS"},
      {"smi", "SMI", result.smi, "", "0 plates, 3 rods, 4 balls"}};
  add_thickness_rows(result, rows);
  if (has_tortuosity) add_path_rows(result, rows);
  if (result.has_diffusion) add_diffusion_rows(result, rows);
  add_form_rows(result, rows);
  if (result.tissue) {
    const auto if_any = [](const DensityMeasure& of, double value) {
      return of.voxels > 0 ? std::optional(value) : std::nullopt;
    };
    const DensityMeasure& in = *result.tissue;
    const DensityMeasure& all = *result.total;
    rows.push_back({"tmd", "TMD", if_any(in, in.mean), "", "mean density of the mask"});
    rows.push_back({"tmd_sd", "TMD.SD", if_any(in, in.deviation), "", "its standard deviation"});
    rows.push_back({"bmd", "BMD", if_any(all, all.mean), "", "mean density of TV"});
    rows.push_back({"bmd_sd", "BMD.SD", if_any(all, all.deviation), "", "its standard deviation"});
  }
  return rows;
}

Facts morphometry_facts(const MorphometryResult& result, bool has_tortuosity) {
  Facts facts;
  for (const MorphometryRow& row : morphometry_rows(result, has_tortuosity)) {
    facts.push_back({row.key, row.value});
  }
  const Facts others = {
      {"thickness", facts_if(result.thickness, thickness_facts)},
      {"spacing", facts_if(result.spacing, thickness_facts)},
      {"ellipsoids", facts_if(result.ellipsoids, ellipsoid_facts)},
      {"mil", facts_if(result.anisotropy, intercept_facts)},
      {"boxes", list_of_facts(result.boxes, box_facts)},
      {"touches_border", result.touches}};
  facts.insert(facts.end(), others.begin(), others.end());
  return facts;
}

FactValue slice_facts(const MorphometryResult& result) {
  const Point3& spacing = result.volume.geometry.spacing_mm;
  const double pixel_mm2 = spacing[0] * spacing[1];
  return list_of_facts(result.slices, [&](const SliceMeasure& slice) -> Facts {
    return {{"area_mm2", static_cast<double>(slice.voxels) * pixel_mm2},
            {"total_mm2", static_cast<double>(slice.region_voxels) * pixel_mm2},
            {"thickness_mm", slice.mean_thickness_mm}};
  });
}

}  // namespace octavo
