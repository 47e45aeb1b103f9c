#include "octavo/planes/memory_source.h"

#include <algorithm>
#include <string>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/planes/plane_cursor.h"

namespace octavo {

namespace {

class MemorySource final : public PlaneSource {
 public:
  MemorySource(const VolumeDescription& description, std::span<const std::byte> voxels)
      : description_(description), voxels_(voxels), cursor_(description.size.z) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  std::uint64_t resident_bytes() const override { return voxels_.size(); }

  void read_plane(std::span<std::byte> plane) override {
    if (plane.size() * static_cast<std::size_t>(description_.size.z) != voxels_.size()) {
      throw Error(ErrorKind::invalid_argument, "a buffer of another size than that of a plane");
    }
    const auto z = static_cast<std::size_t>(cursor_.take());
    const auto from = voxels_.subspan(z * plane.size(), plane.size());
    std::copy(from.begin(), from.end(), plane.begin());
  }

  void seek(std::int64_t first, std::int64_t end) override { cursor_.seek(first, end); }

 private:
  VolumeDescription description_;
  std::span<const std::byte> voxels_;
  std::vector<Warning> warnings_;
  PlaneCursor cursor_;
};

}  // namespace

std::unique_ptr<PlaneSource> make_memory_source(const VolumeDescription& description,
                                                std::span<const std::byte> voxels) {
  const std::uint64_t bytes =
      checked_mul(static_cast<std::uint64_t>(checked_voxel_count(description.size)),
                  static_cast<std::uint64_t>(bytes_per_voxel(description.type)), "the volume");
  if (voxels.size() != bytes) {
    throw Error(ErrorKind::invalid_argument, std::to_string(voxels.size()) +
                                                 " bytes in memory; the description asks for " +
                                                 std::to_string(bytes));
  }
  return std::make_unique<MemorySource>(description, voxels);
}

}  // namespace octavo
