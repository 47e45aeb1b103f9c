// Fields whose gradient is the normal of a surface: what gives relief to a picture of voxel faces.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// A number at every sample of a grid, and beyond its border. Serves any number of threads.
class ReliefField {
 public:
  virtual ~ReliefField() = default;

  /// Writes the numbers in `box` to `values`, dense [z][y][x].
  virtual void read(const Box& box, float* values) const = 0;

  /// Standard deviation of the Gaussian that smooths the field before its gradient is taken,
  /// samples.
  virtual double smoothing() const = 0;

  /// Whether the field goes on beyond the border of the grid, so that a face at it is a cut through
  /// the object and not its surface.
  virtual bool is_cut_at_border() const = 0;
};

/// 1 in any of some masks, 0 elsewhere. The masks must outlive it.
std::unique_ptr<ReliefField> mask_relief(std::span<const MaskTree* const> masks);

/// The values of a level of a grey volume, those at the border also beyond it. What is no number
/// counts as 0.
/// reader  must outlive it
/// Throws  what the reader throws, in `read`
std::unique_ptr<ReliefField> grey_relief(const FileReader& reader, int level);

/// The field around the samples of `box`, smoothed: dense [z][y][x].
std::vector<float> smoothed(const ReliefField& field, const Box& box);

}  // namespace octavo
