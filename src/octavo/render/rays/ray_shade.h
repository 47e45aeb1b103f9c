// How much light comes to places in a volume: from all around, and from where the lamp stands.
//
//         . . .           cones from the middle of each cell of a coarse grid to all sides, and one
//       .  \|/  .         to the lamp; the farther from the cell the wider, and the coarser the
//     . --- x --- .       level of a pyramid of opacities that is looked at
//       .  /|\  .
//
// A coarse level of a file is such a grid. Cells in front of which nothing lies have all light.
//
// Source  cones through a pyramid: Crassin et al., Interactive indirect illumination using voxel
//         cone tracing (2011)
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "octavo/core/geometry.h"
#include "octavo/core/progress.h"
#include "octavo/render/rays/ray_job.h"

namespace octavo {

/// Extinctions of the cells of a grid.
struct ExtinctionGrid {
  Size3 size;
  Geometry geometry;
  std::vector<float> per_mm;  ///< x fastest, none below 0
};

class RayShade {
 public:
  /// Looks around from every cell that light may fall on: those that have an extinction or a
  /// neighbor with one. Uses the threads of the caller's arena.
  /// Throws Error{cancelled}
  RayShade(ExtinctionGrid grid, const Progress& watcher);

  /// Looks from every such cell to the lamp.
  /// toward_light  a unit vector in world space
  /// Throws Error{cancelled}
  void set_lamp(const Point3& toward_light, const Progress& watcher);

  /// The share of the lamp's light that comes through the grid to a place in world space, 0 .. 1.
  /// All of it before there is a lamp.
  float passed_to_lamp(const Point3& world) const;

  /// For rays through a grid.
  /// has_ambient  false: as if light came from all around
  ShadeTable table(const Geometry& rays, bool has_ambient);

  /// Of light from all around and of the lamp's at a cell, 0 .. 1.
  float ambient_at(const Index3& cell) const { return at(ambient_, cell); }
  float direct_at(const Index3& cell) const { return at(direct_, cell); }

 private:
  struct PyramidLevel {
    Size3 size;
    std::vector<float> bordered;  // opacities of cells as thick as their longest side, 0 around

    float at(const std::array<float, 3>& place) const;
  };
  /// Where a cone is looked at: cell * scale + offset, in cells of a level.
  struct ConeStep {
    std::array<float, 3> offset{};
    float scale = 1;
    std::size_t level = 0;
  };
  using LightCone = std::vector<ConeStep>;

  float at(const std::vector<std::uint8_t>& shares, const Index3& cell) const;
  LightCone cone(const Point3& direction, double widening, double begin, double end) const;
  float passed(const std::array<float, 3>& begin, const LightCone& cone) const;
  template <class Share>
  void fill(std::vector<std::uint8_t>& shares, const Progress& watcher, Share&& share_of) const;
  void find_lit(const Size3& size, const std::vector<float>& opacities);

  Geometry geometry_;
  double side_mm_ = 1;  // the longest of a cell
  double reach_mm_ = 1;
  std::vector<PyramidLevel> levels_;
  LightCone to_lamp_;
  std::vector<std::uint8_t> is_lit_;
  std::vector<std::uint8_t> ambient_;
  std::vector<std::uint8_t> direct_;
  std::vector<std::uint8_t> pairs_;
};

}  // namespace octavo
