// A FileReader over a dense volume in memory: level 0 only, any voxel type, no codec in between.
#pragma once

#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo::testing {

class MemoryReader : public FileReader {
 public:
  /// voxels  dense [z][y][x] of description.type; `range` is given as it is
  MemoryReader(VolumeDescription description, std::vector<std::byte> voxels, ValueRange range)
      : description_(std::move(description)),
        levels_(description_.size,
                choose_halvings(description_.size, description_.geometry.spacing_mm)),
        voxels_(std::move(voxels)),
        range_(range),
        source_(byte_source_of({}, "memory")) {}

  const VolumeDescription& description() const override { return description_; }
  const Levels& levels() const override { return levels_; }
  std::uint64_t file_bytes() const override { return voxels_.size(); }
  std::uint64_t build_id() const override { return 1; }
  Sha256Digest voxel_digest() const override { return {}; }
  const ByteSource& source() const override { return *source_; }
  std::string format_version() const override { return "1.0"; }
  ValueRange range() const override { return range_; }
  double max_error() const override { return 0; }
  double achieved_error() const override { return 0; }
  LevelSummary level_summary(int) const override { return {}; }
  AxisOrder axis_order() const override { return kStraightOrder; }
  int detail_level() const override { return 0; }
  std::uint64_t thumbnail_bytes() const override { return 0; }
  Bytes thumbnail() const override { return {}; }
  BrickEntry brick(int, const Index3&) const override { has_none(); }
  void read_brick(const BrickEntry&, int, void*) const override { has_none(); }
  Bytes read_piece(const BrickEntry&, int) const override { has_none(); }

  void read(const Box& box, int level, void* out) const override {
    read_strided(box, level, out, box.size().x, box.size().x * box.size().y);
  }

  void read_strided(const Box& box, int level, void* out, std::int64_t row_stride,
                    std::int64_t plane_stride) const override {
    if (level != 0) has_none();
    const std::int64_t width = bytes_per_voxel(description_.type);
    const Size3& size = description_.size;
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const std::int64_t from = ((z * size.y + y) * size.x + box.lo.x) * width;
        const std::int64_t to = (z - box.lo.z) * plane_stride + (y - box.lo.y) * row_stride;
        std::memcpy(static_cast<std::byte*>(out) + to * width, voxels_.data() + from,
                    static_cast<std::size_t>(box.size().x * width));
      }
    }
  }

 private:
  [[noreturn]] static void has_none() {
    throw Error(ErrorKind::invalid_argument, "a volume in memory has level 0 and no bricks");
  }

  VolumeDescription description_;
  Levels levels_;
  std::vector<std::byte> voxels_;
  ValueRange range_;
  std::shared_ptr<ByteSource> source_;
};

/// Exact floats among which one voxel lies beyond what the codes of the file reach: an end of the
/// range in its index is none.
inline MemoryReader reader_of_unbounded(const Size3& size, std::span<const float> voxels) {
  VolumeDescription description;
  description.size = size;
  description.type = VoxelType::float32;
  description.coding = SampleCoding{VoxelType::int32, 0.5, 0, true};
  const auto bytes = std::as_bytes(voxels);
  return {description, {bytes.begin(), bytes.end()}, {0, SampleCoding::kUnbounded}};
}

}  // namespace octavo::testing
