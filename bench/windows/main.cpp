// The peak of memory while the surface of a file gets fewer triangles: as a whole, and by windows.
//
// usage: bench_windows [--commit ID] FILE ISOVALUE|- whole|windows
//        bench_windows --tube SIDE FILE
//
// ISOVALUE  of grey values, stored: what is at or above lies inside; -: of every label
// --tube    writes a mask of SIDE^3 voxels that holds a tube wound along z, 24 voxels thick
//
// Prints a row: commit, voxels, method, CPU seconds, triangles, all of them, percent, pieces,
// resident memory before, and its peak beyond that, bytes. A process makes one surface.

#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bench/common/measure.h"
#include "bench/common/settings.h"
#include "octavo/builder/tree_builder.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"
#include "octavo/mesh/layered_decimation/layered_decimation.h"
#include "octavo/mesh/mesh_check.h"
#include "octavo/octree/o_code.h"
#include "octavo/ops/mask/mask_pieces.h"

namespace octavo::bench {
namespace {

constexpr std::int64_t kCubeSide = 64;

/// A tube around a line that is wound along z.
class Tube {
 public:
  explicit Tube(std::int64_t side) : middle_(static_cast<double>(side) / 2) {}

  /// Where the line is in a plane.
  std::array<double, 2> at(double z) const {
    const double angle = 2 * std::numbers::pi * z / kTurn;
    return {middle_ + kWound * std::cos(angle), middle_ + kWound * std::sin(angle)};
  }
  bool has(double x, double y, double z) const {
    const auto [cx, cy] = at(z);
    return std::hypot(x - cx, y - cy) < kThick / 2;
  }

  /// The cubes of 64^3 voxels that it meets in a layer.
  std::set<std::array<std::int64_t, 2>> cubes_of(std::int64_t layer) const {
    const auto cube = [](double place) { return static_cast<std::int64_t>(place) / kCubeSide; };
    std::set<std::array<std::int64_t, 2>> cubes;
    for (std::int64_t z = layer * kCubeSide; z < (layer + 1) * kCubeSide; ++z) {
      const auto [x, y] = at(static_cast<double>(z));
      for (const double dx : {-kThick / 2, kThick / 2}) {
        for (const double dy : {-kThick / 2, kThick / 2}) {
          cubes.insert({cube(x + dx), cube(y + dy)});
        }
      }
    }
    return cubes;
  }

 private:
  static constexpr double kTurn = 1000;
  static constexpr double kWound = 150;
  static constexpr double kThick = 24;

  double middle_;
};

MaskTree mask_of(const Tube& tube, std::int64_t side) {
  std::vector<MaskPart> parts;
  std::vector<std::uint64_t> words(4096);
  std::vector<std::pair<std::uint64_t, Index3>> cubes;
  for (std::int64_t layer = 0; layer < side / kCubeSide; ++layer) {
    for (const auto& [x, y] : tube.cubes_of(layer)) {
      const Index3 cube = {x, y, layer};
      cubes.emplace_back(interleave(cube), cube);
    }
  }
  std::sort(cubes.begin(), cubes.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [code, cube] : cubes) {
    bool is_any = false;
    for (std::size_t word = 0; word < words.size(); ++word) {
      words[word] = 0;
      for (std::uint64_t bit = 0; bit < 64; ++bit) {
        const Index3 voxel = deinterleave(64 * word + bit);
        const bool is_in = tube.has(static_cast<double>(cube.x * kCubeSide + voxel.x),
                                    static_cast<double>(cube.y * kCubeSide + voxel.y),
                                    static_cast<double>(cube.z * kCubeSide + voxel.z));
        words[word] |= std::uint64_t{is_in} << bit;
      }
      is_any = is_any || words[word] != 0;
    }
    if (is_any) parts.push_back(fold_cube(words.data(), code));
  }
  return assemble({side, side, side}, 1, parts);
}

void write_tube(std::int64_t side, const std::string& path) {
  if (side < 1024 || side % kCubeSide != 0) {
    throw Error(ErrorKind::invalid_argument, "SIDE is a multiple of 64 from 1024 on");
  }
  const MaskTree mask = mask_of(Tube(side), side);
  VolumeDescription description;
  description.size = {side, side, side};
  description.kind = VolumeKind::labels;
  NoProgress silent;
  build_mask_file({mask, description}, local_storage(), path, {}, silent);
}

void print_surface(const Settings& settings, const std::vector<std::string>& words) {
  const bool is_whole = words[2] == "whole";
  if (!is_whole && words[2] != "windows") {
    throw Error(ErrorKind::invalid_argument, "expected whole or windows: " + words[2]);
  }
  const auto reader = FileReader::open(open_byte_source(local_storage(), words[0]));
  const VolumeDescription& volume = reader->description();
  const SurfaceField field = words[1] == "-"
                                 ? SurfaceField::of_labels({})
                                 : SurfaceField::of_grey(std::stod(words[1]), false, volume.type);
  const auto& [x, y, z] = volume.geometry.spacing_mm;
  LayeredOptions options{.max_deviation_mm = 0.5 * std::min({x, y, z}),
                         .geometry = volume.geometry,
                         .plane_count = volume.size.z};
  if (is_whole) options.window_triangles = UINT64_MAX;
  const std::uint64_t before = resident_memory_bytes();
  reset_peak_memory();
  const double began = cpu_seconds();
  NoProgress silent;
  LayeredDecimation decimation(options, silent);
  extract_surface(*reader, 0, field, decimation, silent);
  LayeredSurface surface = decimation.take();
  if (!surface.is_reduced) {
    surface.mesh = decimate(surface.mesh, {options.max_deviation_mm, volume.geometry}, silent).mesh;
  }
  const double seconds = cpu_seconds() - began;
  const std::uint64_t peak = peak_memory_bytes();
  const MeshCheck check = check_mesh(surface.mesh);
  if (!check.is_closed() || !check.is_manifold() || surface.is_turned) {
    throw Error(ErrorKind::internal, "the surface has faults");
  }
  std::printf("%s,%lldx%lldx%lld,%s,%.2f,%zu,%llu,%.2f,%llu,%llu,%llu\n", settings.commit.c_str(),
              static_cast<long long>(volume.size.x), static_cast<long long>(volume.size.y),
              static_cast<long long>(volume.size.z), words[2].c_str(), seconds,
              surface.mesh.triangles.size(),
              static_cast<unsigned long long>(surface.full_triangle_count),
              100 * static_cast<double>(surface.mesh.triangles.size()) /
                  static_cast<double>(surface.full_triangle_count),
              static_cast<unsigned long long>(check.components),
              static_cast<unsigned long long>(before),
              static_cast<unsigned long long>(peak - before));
}

void run_windows(int count, char** words) {
  Settings settings;
  const std::vector<std::string> rest = take_settings(count, words, settings);
  const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(settings.threads));
  if (rest.size() == 3 && rest[0] == "--tube") write_tube(std::stoll(rest[1]), rest[2]);
  else if (rest.size() == 3) print_surface(settings, rest);
  else throw Error(ErrorKind::invalid_argument, "usage: bench_windows FILE ISOVALUE|- METHOD");
}

}  // namespace
}  // namespace octavo::bench

int main(int count, char** words) {
  return octavo::bench::run_named("bench_windows",
                                  [&] { octavo::bench::run_windows(count, words); });
}
