#include "octavo/planes/memory_source.h"

#include <algorithm>
#include <string>

#include "octavo/core/checked.h"
#include "octavo/core/error.h"
#include "octavo/core/levels.h"

namespace octavo {

namespace {

class MemorySource final : public PlaneSource {
 public:
  MemorySource(const VolumeDescription& description, std::span<const std::byte> voxels)
      : description_(description), voxels_(voxels) {}

  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  std::uint64_t resident_bytes() const override { return voxels_.size(); }

  void read_plane(std::span<std::byte> plane) override {
    if (voxels_.size() - next_ < plane.size()) {
      throw Error(ErrorKind::invalid_argument,
                  "no plane is left of the " + std::to_string(description_.size.z) + " in memory");
    }
    const auto from = voxels_.subspan(next_, plane.size());
    std::copy(from.begin(), from.end(), plane.begin());
    next_ += plane.size();
  }

 private:
  VolumeDescription description_;
  std::span<const std::byte> voxels_;
  std::vector<Warning> warnings_;
  std::size_t next_ = 0;
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
