// Surfaces of voxels in memory.
//
// usage: bench_surfaces [--rounds N] [--threads N] VOLUME ISOVALUE
//
// VOLUME and ISOVALUE as common/surface_input.h says.
//
// Prints a line for each round: CPU seconds of the process, triangles, points. The surface is
// proven closed and manifold before the first. Each round makes a mesh of its own.

#include <cstdio>

#include "bench/common/measure.h"
#include "bench/common/surface_input.h"
#include "octavo/mesh/mesh_check.h"

namespace octavo::bench {
namespace {

void run_surfaces(int count, char** words) {
  const SurfaceInput input("bench_surfaces", count, words);
  const MeshCheck check = check_mesh(input.surface());
  if (!check.is_closed() || !check.is_manifold()) {
    throw Error(ErrorKind::internal, "the surface has faults");
  }
  for (int round = 0; round < input.rounds(); ++round) {
    const double began = cpu_seconds();
    const TriangleMesh mesh = input.surface();
    const double seconds = cpu_seconds() - began;
    std::printf("%.6f %zu %zu\n", seconds, mesh.triangles.size(), mesh.points.size());
  }
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_surfaces",
                                  [&] { octavo::bench::run_surfaces(count, words); });
}
