// Surfaces of voxels in memory.
//
// usage: bench_surfaces [--rounds N] [--threads N] VOLUME ISOVALUE
//
// VOLUME    "NAME PATH nx,ny,nz,type", a headerless file
// ISOVALUE  stored values at or above it lie inside
//
// Prints a line for each round: CPU seconds of the process, triangles, points. The surface is
// proven closed and manifold before the first. Each round makes a mesh of its own.

#include <ctime>

#include <tbb/global_control.h>

#include <cstdio>
#include <string>

#include "bench/common/raw_volume.h"
#include "bench/common/settings.h"
#include "octavo/core/error.h"
#include "octavo/mesh/memory_surface.h"
#include "octavo/mesh/mesh_check.h"

namespace octavo::bench {
namespace {

double cpu_seconds() {
  timespec now{};
  ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

void run_surfaces(int count, char** words) {
  Settings settings;
  const std::vector<std::string> rest = take_settings(count, words, settings);
  if (rest.size() != 2) {
    throw Error(ErrorKind::invalid_argument,
                "usage: bench_surfaces [--rounds N] [--threads N] VOLUME ISOVALUE");
  }
  const RawVolume raw = load_raw_volume(rest[0]);
  const VoxelsInMemory volume = {raw.voxels.data(), raw.type, raw.size, {}};
  const SurfaceField field = SurfaceField::of_grey(std::stod(rest[1]), false, raw.type);
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(settings.threads));
  NoProgress silent;
  const MeshCheck check = check_mesh(surface_of(volume, field, silent));
  if (!check.is_closed() || !check.is_manifold()) {
    throw Error(ErrorKind::internal, "the surface has faults");
  }
  for (int round = 0; round < settings.rounds; ++round) {
    const double began = cpu_seconds();
    const TriangleMesh mesh = surface_of(volume, field, silent);
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
