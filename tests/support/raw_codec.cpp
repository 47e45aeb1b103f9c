// A codec that stores every level as it is: container tests through it depend on no compression.
// With a max error e it stores voxels as far away as it may: rounded down to multiples of e + 1.
// It stands in for the real ones wherever it is linked.
#include <algorithm>
#include <cstring>

#include "octavo/codec/brick_codec.h"
#include "octavo/codec/refine_model.h"
#include "octavo/core/error.h"

namespace octavo {

namespace {

class RawCodec final : public BrickCodec {
 public:
  RawCodec(VolumeKind kind, VoxelType type, std::int64_t max_error = 0)
      : kind_(kind), type_(type), max_error_(max_error) {}

  VolumeKind kind() const noexcept override { return kind_; }
  Bytes serialized() const override { return {'r', 'a', 'w'}; }

  // A coarser sample is the first of its octant.
  EncodedBrick encode(const BrickShape& shape, const BrickView& brick) const override {
    const auto bytes = static_cast<std::size_t>(bytes_per_voxel(type_));
    EncodedBrick result;
    result.segments.resize(static_cast<std::size_t>(shape.level_count));
    Size3 step{1, 1, 1};
    for (std::size_t i = 0; i < result.segments.size(); ++i) {
      const Size3& size = shape.size[i];
      Bytes& segment = result.segments[i];
      for (std::int64_t z = 0; z < size.z; ++z) {
        for (std::int64_t y = 0; y < size.y; ++y) {
          for (std::int64_t x = 0; x < size.x; ++x) {
            const std::int64_t at = z * step.z * brick.plane_stride +
                                    y * step.y * brick.row_stride + x * step.x;
            const auto* voxel = static_cast<const std::uint8_t*>(brick.voxels) +
                                static_cast<std::size_t>(at) * bytes;
            segment.insert(segment.end(), voxel, voxel + bytes);
          }
        }
      }
      for (int axis = 0; axis < 3; ++axis) step[axis] <<= shape.halving[i] >> axis & 1;
    }
    with_voxel_type(type_, [&](auto tag) {
      using T = typename decltype(tag)::type;
      std::vector<T> voxels(result.segments[0].size() / sizeof(T));
      for (Bytes& segment : result.segments) coarsen<T>(segment);
      std::memcpy(voxels.data(), result.segments[0].data(), result.segments[0].size());
      const auto [low, high] = std::minmax_element(voxels.begin(), voxels.end());
      result.range = {static_cast<std::int64_t>(*low), static_cast<std::int64_t>(*high)};
      result.parent = static_cast<std::int64_t>(voxels[0]);
    });
    if (result.range.min == result.range.max) {
      for (Bytes& segment : result.segments) segment.clear();
    }
    return result;
  }

  void decode(const BrickShape& shape, VoxelType type, const ValueRange&,
              std::span<const ByteSpan> segments, int level, void* out) const override {
    const auto slot = static_cast<std::size_t>(level);
    const std::int64_t bytes = shape.size[slot].voxel_count() * bytes_per_voxel(type);
    if (segments[slot].size() != static_cast<std::size_t>(bytes)) {
      throw Error(ErrorKind::corrupt, "segment of another size");
    }
    std::memcpy(out, segments[slot].data(), segments[slot].size());
  }

  std::int64_t decode_parent(const BrickShape&, VoxelType type, const ValueRange& range,
                             std::span<const ByteSpan> segments) const override {
    if (range.min == range.max) return range.min;
    const ByteSpan coarsest = segments.back();
    if (coarsest.empty()) throw Error(ErrorKind::corrupt, "no coarsest samples");
    return with_voxel_type(type, [&](auto tag) {
      typename decltype(tag)::type first;
      std::memcpy(&first, coarsest.data(), sizeof first);
      return static_cast<std::int64_t>(first);
    });
  }

 private:
  // Multiples of e + 1 that the type holds.
  template <class T>
  void coarsen(Bytes& segment) const {
    if (max_error_ == 0) return;
    for (std::size_t at = 0; at < segment.size(); at += sizeof(T)) {
      T voxel;
      std::memcpy(&voxel, segment.data() + at, sizeof voxel);
      const auto value = static_cast<std::int64_t>(voxel);
      const std::int64_t step = max_error_ + 1;
      const std::int64_t below = value - ((value % step) + step) % step;
      const auto kept = static_cast<std::int64_t>(static_cast<T>(below)) == below ? below : value;
      voxel = static_cast<T>(kept);
      std::memcpy(segment.data() + at, &voxel, sizeof voxel);
    }
  }

  VolumeKind kind_;
  VoxelType type_;
  std::int64_t max_error_;
};

}  // namespace

std::unique_ptr<BrickCodec> train_model(VolumeKind kind, VoxelType type,
                                        std::span<const TrainingBrick>,
                                        const CodecSettings& settings) {
  return std::make_unique<RawCodec>(kind, type, settings.max_error);
}

std::unique_ptr<BrickCodec> refine_model(const BrickCodec& first, VoxelType type,
                                         std::span<const TrainingBrick> bricks,
                                         const CodecSettings& settings) {
  return train_model(first.kind(), type, bricks, settings);
}

std::unique_ptr<BrickCodec> parse_model(VolumeKind kind, VoxelType type, ByteSpan bytes, int) {
  if (bytes.size() != 3) throw Error(ErrorKind::corrupt, "model of another size");
  return std::make_unique<RawCodec>(kind, type);
}

}  // namespace octavo
