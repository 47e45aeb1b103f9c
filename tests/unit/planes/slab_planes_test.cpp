#include "octavo/planes/slab_planes.h"

#include <gtest/gtest.h>

#include <utility>

#include "octavo/core/error.h"

namespace octavo {
namespace {

/// Planes of 3 x 2 voxels that all have the number of their plane.
class Numbered final : public SlabPlanes {
 public:
  Numbered() : SlabPlanes(4, 10, "numbered") {
    description_.size = {3, 2, 10};
    description_.type = VoxelType::uint8;
  }
  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  std::uint64_t resident_bytes() const override { return slab_bytes(); }
  const PlaneFiles& files() const override { return files_; }

  std::vector<int> next() {
    std::vector<std::byte> plane(6);
    read_plane(plane);
    std::vector<int> values;
    for (const std::byte value : plane) values.push_back(static_cast<int>(value));
    return values;
  }

  std::vector<std::pair<std::int64_t, std::int64_t>> filled;
  bool fails = false;

 private:
  void fill_slab(std::int64_t begin, std::int64_t end, std::span<std::byte> slab) override {
    if (fails) throw Error(ErrorKind::io, "fails");
    filled.emplace_back(begin, end);
    for (std::size_t i = 0; i < slab.size(); ++i) {
      slab[i] = static_cast<std::byte>(static_cast<std::size_t>(begin) + i / 6);
    }
  }

  VolumeDescription description_;
  std::vector<Warning> warnings_;
  PlaneFiles files_;
};

TEST(SlabPlanes, FillsEachSlabOnce) {
  Numbered planes;
  for (int z = 0; z < 10; ++z) EXPECT_EQ(planes.next(), std::vector<int>(6, z));
  using Slabs = std::vector<std::pair<std::int64_t, std::int64_t>>;
  EXPECT_EQ(planes.filled, (Slabs{{0, 4}, {4, 8}, {8, 10}}));
  EXPECT_THROW(planes.next(), Error);
  planes.seek(9, 10);
  EXPECT_EQ(planes.next(), std::vector<int>(6, 9));
  planes.seek(2, 3);
  EXPECT_EQ(planes.next(), std::vector<int>(6, 2));
  EXPECT_EQ(planes.filled.size(), 4u);
  EXPECT_EQ(planes.resident_bytes(), 24u);
}

TEST(SlabPlanes, AFailureIsNoPlane) {
  Numbered planes;
  planes.next();
  planes.seek(5, 10);
  planes.fails = true;
  EXPECT_THROW(planes.next(), Error);
  planes.fails = false;
  EXPECT_EQ(planes.next(), std::vector<int>(6, 5));
  planes.seek(1, 2);
  EXPECT_EQ(planes.next(), std::vector<int>(6, 1));
}

}  // namespace
}  // namespace octavo
