// Surfaces with fewer triangles: collapsed edges, merged cells, and meshoptimizer with the same
// error asked for.
//
// usage: bench_decimations [--rounds N] [--threads N] VOLUME ISOVALUE
//
// VOLUME and ISOVALUE as common/surface_input.h says.
//
// Half the shortest side of a voxel is allowed. Prints a line for each method and round: method,
// CPU seconds of the process, triangles, percent of all, deviation in mm as proven for all of them
// alike, edges and points that are no manifold, triangles that cross, pieces. The result of a
// round is checked behind its timing.

#include <meshoptimizer.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/surface_input.h"
#include "octavo/mesh/measured_deviation.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/mesh/octree_decimation/octree_decimation.h"
#include "octavo/mesh/triangle_tree.h"

namespace octavo::bench {
namespace {

TriangleMesh simplified(const TriangleMesh& full, double deviation_mm) {
  const float* places = full.points.front().data();
  const std::size_t stride = sizeof(MeshPoint);
  std::vector<unsigned int> numbers;
  for (const MeshTriangle& t : full.triangles) numbers.insert(numbers.end(), t.begin(), t.end());
  std::vector<unsigned int> left(numbers.size());
  const float scale = meshopt_simplifyScale(places, full.points.size(), stride);
  left.resize(meshopt_simplify(left.data(), numbers.data(), numbers.size(), places,
                               full.points.size(), stride, 0,
                               static_cast<float>(deviation_mm) / scale, 0, nullptr));
  TriangleMesh made{full.points, {}};
  for (std::size_t i = 0; i < left.size(); i += 3) {
    made.triangles.push_back({left[i], left[i + 1], left[i + 2]});
  }
  return made;
}

void print_round(const char* method, double seconds, const TriangleMesh& full,
                 const TriangleMesh& mesh, double largest) {
  NoProgress silent;
  const MeshCheck check = check_mesh(mesh);
  const double deviation = measured_deviation(full, mesh, largest, 1e-6, silent);
  std::printf("%s %.3f %zu %.2f %.4f %llu %llu %zu %llu\n", method, seconds,
              mesh.triangles.size(),
              100 * static_cast<double>(mesh.triangles.size()) /
                  static_cast<double>(full.triangles.size()),
              deviation,
              static_cast<unsigned long long>(check.open_sides + check.repeated_sides),
              static_cast<unsigned long long>(check.pinched_points),
              crossing_triangles(TriangleTree(mesh), silent).size(),
              static_cast<unsigned long long>(check.components));
}

void run_decimations(int count, char** words) {
  const SurfaceInput input("bench_decimations", count, words);
  const Geometry geometry = input.geometry();
  const TriangleMesh full = input.surface();
  NoProgress silent;
  const auto& [x, y, z] = geometry.spacing_mm;
  const double deviation = 0.5 * std::min({x, y, z});
  constexpr double kFar = 100;  // mm, beyond what any method does
  for (int round = 0; round < input.rounds(); ++round) {
    const auto timed = [&](const char* method, double largest,
                           const std::function<TriangleMesh()>& make) {
      const double began = cpu_seconds();
      const TriangleMesh mesh = make();
      print_round(method, cpu_seconds() - began, full, mesh, largest);
    };
    timed("collapse", deviation,
          [&] { return decimate(full, {deviation, geometry}, silent).mesh; });
    timed("octree", deviation,
          [&] { return decimate_by_cells(full, {deviation, geometry}, silent).mesh; });
    timed("meshoptimizer", kFar, [&] { return simplified(full, deviation); });
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_decimations",
                                  [&] { octavo::bench::run_decimations(count, words); });
}
