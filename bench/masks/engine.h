// One library's masks: what every library of the contest does with the same volumes.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/core/box.h"

namespace octavo::bench {

/// Voxels in memory, [z][y][x]; the mask is lowest <= voxel.
struct MaskVolume {
  std::string name;
  Size3 size;
  std::vector<std::int16_t> voxels;
  std::int16_t lowest = 0;
};

/// One thing that is timed.
struct MaskOperation {
  std::string name;
  std::function<std::uint64_t()> run;  ///< gives a number on which all libraries must agree
  std::function<void()> prepare;       ///< before every run, not timed; may be empty
};

/// A mask of `a` and one of `b` in some library. Makes both when it is constructed.
class MaskEngine {
 public:
  virtual ~MaskEngine() = default;
  virtual std::string name() const = 0;
  /// Bytes of the mask of `a`.
  virtual std::uint64_t memory_bytes() const = 0;
  virtual std::vector<MaskOperation> operations() = 0;
};

/// How many random voxels "random voxels" asks for.
inline constexpr std::int64_t kRandomVoxels = 1 << 20;

/// Calls visit(x, y, z) for the same random voxels each time.
template <class Visit>
void for_random_voxels(const Size3& size, Visit&& visit) {
  std::uint64_t state = 1;
  const auto below = [&](std::int64_t n) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::int64_t>((state >> 33) * static_cast<std::uint64_t>(n) >> 31);
  };
  for (std::int64_t i = 0; i < kRandomVoxels; ++i) {
    const std::int64_t x = below(size.x);
    const std::int64_t y = below(size.y);
    visit(x, y, below(size.z));
  }
}

std::unique_ptr<MaskEngine> make_octavo_masks(const MaskVolume& a, const MaskVolume& b);
std::unique_ptr<MaskEngine> make_openvdb_masks(const MaskVolume& a, const MaskVolume& b);
std::unique_ptr<MaskEngine> make_itk_masks(const MaskVolume& a, const MaskVolume& b);

}  // namespace octavo::bench
