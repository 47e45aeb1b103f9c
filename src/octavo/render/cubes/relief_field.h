// Fields whose gradient is the normal of a surface: what gives relief to a picture of voxel faces.
#pragma once

#include <cstddef>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "octavo/file/reader.h"
#include "octavo/octree/mask_tree.h"

namespace octavo {

/// Numbers at every sample of a grid, and beyond its border, that rise into the object: one field,
/// or one for each of several masks. Serves any number of threads.
class ReliefField {
 public:
  virtual ~ReliefField() = default;

  /// The number of the field that the surface of a mask follows.
  virtual std::size_t field_of(std::size_t mask) const = 0;

  /// Writes the numbers of a field in `box` to `values`, dense [z][y][x].
  virtual void read(std::size_t field, const Box& box, float* values) const = 0;

  /// Standard deviation of the Gaussian that smooths the field before its gradient is taken,
  /// samples.
  virtual double smoothing() const = 0;

  /// Whether the field goes on beyond the border of the grid, so that a face at it is a cut through
  /// the object and not its surface.
  virtual bool is_cut_at_border() const = 0;
};

/// 1 in any of some masks, 0 elsewhere. The masks must outlive it.
std::unique_ptr<ReliefField> mask_relief(std::span<const MaskTree* const> masks);

/// The stored values that a mask holds.
struct ReliefRange {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();
};

/// How far the values of a level of a grey volume lie within the range of a mask, or below 0 beyond
/// it; those at the border also outside the volume. Infinities count as the ends of the finite
/// values of the file, NaN as far outside the range as these reach inside.
/// reader  must outlive it
/// ranges  of the masks, in their order
/// Throws  what the reader throws, in `read`
std::unique_ptr<ReliefField> grey_relief(const FileReader& reader, int level,
                                         std::vector<ReliefRange> ranges);

/// A field around the samples of `box`, smoothed: dense [z][y][x].
std::vector<float> smoothed(const ReliefField& relief, std::size_t field, const Box& box);

}  // namespace octavo
