#include "octavo/planes/computed_source.h"

#include <algorithm>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

class ComputedSource final : public PlaneSource {
 public:
  ComputedSource(const VolumeDescription& description, FillBox fill, std::int64_t planes_at_once)
      : description_(description),
        fill_(std::move(fill)),
        planes_at_once_(planes_at_once),
        cursor_(description.size.z) {
    checked_voxel_count(description.size);
  }

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }

  std::uint64_t resident_bytes() const override {
    const Size3& size = description_.size;
    return static_cast<std::uint64_t>(size.x * size.y * std::min(size.z, planes_at_once_) *
                                      bytes_per_voxel(description_.type));
  }

  void read_plane(std::span<std::byte> plane) override {
    const Size3& size = description_.size;
    const auto bytes =
        static_cast<std::size_t>(size.x * size.y * bytes_per_voxel(description_.type));
    if (plane.size() != bytes) {
      throw Error(ErrorKind::invalid_argument, "a buffer of another size than that of a plane");
    }
    const std::int64_t z = cursor_.take();
    if (z < first_ || z >= end_) {
      end_ = std::min(cursor_.end(), z + planes_at_once_);
      first_ = z;
      voxels_.resize(bytes * static_cast<std::size_t>(end_ - first_));
      fill_({{0, 0, first_}, {size.x, size.y, end_}}, voxels_.data());
    }
    const auto at = static_cast<std::ptrdiff_t>(bytes) * (z - first_);
    std::copy_n(voxels_.begin() + at, bytes, plane.begin());
  }

  void seek(std::int64_t first, std::int64_t end) override { cursor_.seek(first, end); }

 private:
  VolumeDescription description_;
  FillBox fill_;
  std::int64_t planes_at_once_;
  std::vector<Warning> warnings_;
  std::vector<std::byte> voxels_;  // of planes first_ .. end_
  std::int64_t first_ = 0;
  std::int64_t end_ = 0;
  PlaneCursor cursor_;
};

}  // namespace

std::unique_ptr<PlaneSource> make_computed_source(const VolumeDescription& description,
                                                  FillBox fill, std::int64_t planes_at_once) {
  return std::make_unique<ComputedSource>(description, std::move(fill), planes_at_once);
}

}  // namespace octavo
