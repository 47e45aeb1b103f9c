// A large volume that is built fast: uniform but for one column of bricks.
#pragma once

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/volume.h"
#include "octavo/planes/plane_source.h"

namespace octavo::testing {

/// Planes of zeros, of which a corner, or what there is of it, holds a texture that is another in
/// every group of 64 planes; or eight bricks of each hold one that is alike in all.
/// Throws Error{source_rejected} at `failing_plane`.
class TextureSource final : public PlaneSource {
 public:
  /// 512 x 512 x 150 voxels of 16 bits are three groups.
  static constexpr Size3 kThreeGroups = {512, 512, 150};
  static constexpr std::int64_t kGroupPlanes = 64;

  explicit TextureSource(VolumeDescription description, std::int64_t failing_plane = -1)
      : description_(std::move(description)), failing_plane_(failing_plane) {}

  /// size  of planes smaller than kThreeGroups: three groups under SmallGroups(1)
  static VolumeDescription three_groups(VoxelType type = VoxelType::int16,
                                        VolumeKind kind = VolumeKind::grey,
                                        Size3 size = kThreeGroups) {
    VolumeDescription description;
    description.type = type;
    description.kind = kind;
    description.size = size;
    return description;
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  void read_plane(std::span<std::byte> plane) override {
    if (z_ == failing_plane_) throw Error(ErrorKind::source_rejected, "torn", "slice.dcm");
    std::fill(plane.begin(), plane.end(), std::byte{0});
    with_voxel_type(description_.type, [&](auto tag) {
      using T = typename decltype(tag)::type;
      const Size3& size = description_.size;
      for (std::int64_t y = 0; y < std::min<std::int64_t>(size.y, is_alike ? 128 : 50); ++y) {
        for (std::int64_t x = 0; x < std::min<std::int64_t>(size.x, is_alike ? 256 : 60); ++x) {
          state_ = state_ * 1664525u + 1013904223u;
          const bool is_quiet = z_ < kGroupPlanes || is_alike;
          const std::uint32_t noise = state_ >> (is_quiet ? 29 : 27);
          const std::int64_t depth = is_alike ? z_ % kGroupPlanes : z_;
          const auto value = static_cast<T>(static_cast<std::uint32_t>(x + 2 * depth) / 4 + noise);
          const auto at = static_cast<std::size_t>(y * description_.size.x + x) * sizeof(T);
          std::memcpy(plane.data() + at, &value, sizeof value);
        }
      }
      if (z_ == changed_plane) plane.back() = std::byte{1};
    });
    ++z_;
  }
  // Its noise goes from voxel to voxel.
  void seek(std::int64_t first, std::int64_t) override {
    if (first < z_) {
      z_ = 0;
      state_ = 1;
    }
    std::vector<std::byte> passed(static_cast<std::size_t>(plane_bytes(description_)));
    while (z_ < first) read_plane(passed);
  }
  bool can_seek() const override { return false; }

  VolumeDescription& mutable_description() { return description_; }
  bool is_alike = false;            ///< the groups differ no more than those of one scan
  std::int64_t changed_plane = -1;  ///< in which one more voxel is not 0

 private:
  VolumeDescription description_;
  std::vector<Warning> warnings_;
  std::int64_t failing_plane_;
  std::int64_t z_ = 0;
  std::uint32_t state_ = 1;
};

}  // namespace octavo::testing
