// The part of a grid that rays cross, as boxes that they come to one after the other.
//
//     +-------+-------+      a box without a smaller one in it is up to six boxes
//     |       |  cut  |
//     |   1   +-------+      rays from the left come to 1, then to 2
//     |       |   2   |
//     +-------+-------+
#pragma once

#include <span>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/levels.h"
#include "octavo/render/rays/ray_job.h"

namespace octavo {

/// A box in samples; its faces are those of samples where it ends at n - 0.5.
struct RayRegion {
  std::array<float, 3> low{};
  std::array<float, 3> high{};
  /// The box that it is a part of. At faces that it does not share with it steps are not cut: all
  /// parts of a box together give its steps, bit for bit.
  std::array<float, 3> whole_low{};
  std::array<float, 3> whole_high{};

  bool operator==(const RayRegion&) const = default;
};

/// The voxels of a box.
RayRegion region_of(const Box& voxels);

/// A box of voxels of level 0, in samples of another level.
RayRegion region_at_level(const Box& voxels, const Levels& levels, int level);

/// What of a region lies in another one.
RayRegion region_within(const RayRegion& region, const RayRegion& outer);

/// What rays of the voxels of a box without others take no values from, boxes of a grid.
class KeptVoxels {
 public:
  /// removed  empty ones, as boxes of few voxels are on coarser levels, take nothing away
  KeptVoxels(const Box& kept, std::span<const Box> removed, const Size3& size);
  KeptVoxels(const KeptVoxels&) = delete;
  KeptVoxels& operator=(const KeptVoxels&) = delete;

  /// Valid as long as this; none where all of the grid is kept.
  const RayCuts* cuts() const { return is_all_ ? nullptr : &cuts_; }

 private:
  bool is_all_ = false;
  std::vector<RayCuts::Hole> holes_;
  RayCuts cuts_;
};

/// What is left of a box without others, as boxes that do not meet.
std::vector<Box> without_boxes(const Box& whole, std::span<const Box> removed);

/// Regions that do not meet, in an order in which every ray of a frame comes to them. Where there
/// is none they are cut into smaller ones.
/// frame  with its camera
std::vector<RayRegion> front_to_back(std::vector<RayRegion> regions, const RayFrame& frame);

}  // namespace octavo
