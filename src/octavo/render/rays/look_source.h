// What voxels look like besides their values: a number beside each sample, out of a mask or a label
// map on the same grid.
#pragma once

#include <cstdint>
#include <span>

#include "octavo/core/box.h"

namespace octavo {

/// Functions of colors and opacities: bit i stands for the one of number i.
using LookSet = std::uint32_t;
inline constexpr std::size_t kMostLookFunctions = 32;

/// Reading from it is thread-safe.
class LookSource {
 public:
  virtual ~LookSource() = default;

  /// By look, the function that it has; nothing where it is not seen.
  virtual std::span<const LookSet> sets() const = 0;
  /// All that may be in a box, as far as it is known without reading any.
  virtual LookSet within(const Box& box) const = 0;
  /// Reads the looks of a box that lies inside, dense [z][y][x]. All are below sets().size().
  virtual void read(const Box& box, std::uint16_t* out) const = 0;
};

}  // namespace octavo
