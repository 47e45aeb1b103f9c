#include "octavo/mesh/decimation_steps.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "octavo/mesh/decimation_frame.h"
#include "octavo/mesh/deviation_search.h"

namespace octavo {

double first_step_mm(const Geometry& geometry) { return 0.5 * shortest_side(geometry); }

Decimated decimate_further(const TriangleMesh& base, std::uint64_t full_count, double deviation_mm,
                           const Geometry& geometry, Progress& progress) {
  // Fewer triangles take larger parts, so that as many of their points are free.
  DecimationOptions options{deviation_mm, geometry};
  options.part_side *=
      std::sqrt(static_cast<double>(full_count) /
                static_cast<double>(std::max<std::size_t>(base.triangles.size(), 1)));
  return decimate(base, options, progress);
}

Decimated decimate_in_steps(const TriangleMesh& full, const DecimationOptions& options,
                            Progress& progress) {
  const double first = std::min(options.max_deviation_mm, first_step_mm(options.geometry));
  const std::uint64_t full_count = full.triangles.size();
  Decimated reduced = decimate_further(full, full_count, first, options.geometry, progress);
  return decimate_in_further_steps(std::move(reduced), first, full_count, options, progress);
}

Decimated decimate_in_further_steps(Decimated reduced, double proven_mm, std::uint64_t full_count,
                                    const DecimationOptions& options, Progress& progress) {
  const double asked = options.max_deviation_mm;
  double target = proven_mm;
  double proven = proven_mm;
  for (int stalls = 0; target < asked && stalls < kMostStalledSteps;) {
    target = std::min(kLoosening * target, asked);
    Decimated further =
        decimate_further(reduced.mesh, full_count, target - proven, options.geometry, progress);
    const auto before = static_cast<double>(reduced.mesh.triangles.size());
    const auto after = static_cast<double>(further.mesh.triangles.size());
    stalls = after > kStalledShare * before ? stalls + 1 : 0;
    if (after >= before) continue;
    further.rounds += reduced.rounds;
    reduced = std::move(further);
    proven = target;
  }
  return reduced;
}

}  // namespace octavo
