#include "octavo/dist/codec_check.h"

#include <map>
#include <mutex>
#include <span>
#include <tuple>
#include <vector>

#include "octavo/builder/build_outline.h"
#include "octavo/builder/group_reader.h"
#include "octavo/builder/group_trainer.h"
#include "octavo/builder/tier_encoder.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/planes/memory_source.h"

namespace octavo {

namespace {

constexpr Size3 kCheckedSize = {20, 14, 12};

/// Sums up what a writer would have got.
class CheckSink final : public BrickSink {
 public:
  void add_model(const Bytes& model) override { crc_ = crc32c(model, crc_); }

  void add_brick(int, const EncodedBrick& brick) override {
    Bytes numbers;
    ByteWriter out(numbers);
    for (const std::int64_t number :
         {brick.range.min, brick.range.max, brick.parent, brick.max_error}) {
      out.put_signed(number);
    }
    crc_ = crc32c(numbers, crc_);
    for (const Bytes& segment : brick.segments) crc_ = crc32c(segment, crc_);
  }

  void add_plane_digests(std::span<const Sha256Digest> digests) override {
    for (const Sha256Digest& digest : digests) crc_ = crc32c(digest, crc_);
  }

  void end_group(std::uint32_t voxels_crc) override {
    const std::uint8_t bytes[] = {static_cast<std::uint8_t>(voxels_crc),
                                  static_cast<std::uint8_t>(voxels_crc >> 8),
                                  static_cast<std::uint8_t>(voxels_crc >> 16),
                                  static_cast<std::uint8_t>(voxels_crc >> 24)};
    crc_ = crc32c(bytes, crc_);
  }

  std::uint32_t crc() const { return crc_; }

 private:
  std::uint32_t crc_ = 0;
};

/// A slope with a bright ball in it and some noise; of labels regions.
std::int64_t checked_value(std::int64_t x, std::int64_t y, std::int64_t z, std::uint32_t noise,
                           VolumeKind kind) {
  const std::int64_t dx = x - 10;
  const std::int64_t dy = y - 7;
  const std::int64_t dz = z - 6;
  const bool is_inside = dx * dx + dy * dy + dz * dz < 20;
  if (kind == VolumeKind::labels) return is_inside ? 7 : x / 5 + 4 * (y / 7);
  return 20 * x + 11 * y - 3 * z + (is_inside ? 900 : 0) + static_cast<std::int64_t>(noise >> 28);
}

std::vector<std::byte> checked_voxels(VoxelType type, VolumeKind kind) {
  std::vector<std::byte> voxels;
  std::uint32_t state = 1;
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    for (std::int64_t i = 0; i < kCheckedSize.voxel_count(); ++i) {
      state = state * 1664525u + 1013904223u;
      const std::int64_t x = i % kCheckedSize.x;
      const std::int64_t y = i / kCheckedSize.x % kCheckedSize.y;
      const std::int64_t z = i / (kCheckedSize.x * kCheckedSize.y);
      auto value = static_cast<T>(checked_value(x, y, z, state, kind));
      // Floats of eighths, as a mean of eight voxels has them
      if constexpr (!std::is_integral_v<T>) value += static_cast<T>(state >> 29) / 8;
      const auto* const bytes = reinterpret_cast<const std::byte*>(&value);
      voxels.insert(voxels.end(), bytes, bytes + sizeof value);
    }
  });
  return voxels;
}

struct CheckedVolume {
  VoxelType type;
  VolumeKind kind = VolumeKind::grey;
  Preset preset = Preset::fast;
  double max_error = 0;
};

std::uint32_t check_of(const CheckedVolume& row) {
  VolumeDescription description;
  description.type = row.type;
  description.kind = row.kind;
  description.size = kCheckedSize;
  const std::vector<std::byte> voxels = checked_voxels(row.type, row.kind);
  const auto source = make_memory_source(description, voxels);
  BuildOptions options;
  options.kind = row.kind;
  options.preset = row.preset;
  options.max_error = row.max_error;
  NoProgress progress;

  BuildOutline outline = outline_build(description, options);
  choose_bounds(outline, *source, options, progress);
  Workers workers(1);
  GroupTrainer trainer(outline.description, outline.levels, workers, outline.settings);
  GroupReader reader(outline.planes(*source), outline.levels, progress, outline.float_voxels());
  CheckSink sink;
  TierEncoder encoder(outline.levels, 0, outline.description.codec_type(), workers, sink, progress,
                      outline.bound);
  while (!reader.is_done()) {
    const VoxelBlock block = reader.next(workers);
    encoder.start(trainer.train(block), block, true, [&reader] { reader.release(); });
  }
  encoder.finish();
  return sink.crc();
}

/// The volume that is made as the planned one.
CheckedVolume checked_volume(VoxelType type, const BuildOptions& options) {
  if (options.kind == VolumeKind::labels) {
    return {.type = VoxelType::uint8, .kind = VolumeKind::labels, .preset = options.preset};
  }
  const bool is_float = type == VoxelType::float32;
  const double max_error = options.max_error == 0 ? 0 : is_float ? 0.3 : 5;
  return {.type = is_float ? VoxelType::float32 : VoxelType::int16,
          .preset = options.preset,
          .max_error = max_error};
}

}  // namespace

std::uint32_t codec_check(VoxelType type, const BuildOptions& options) {
  using Kind = std::tuple<VoxelType, VolumeKind, Preset, double>;
  static std::mutex mutex;
  static std::map<Kind, std::uint32_t> found;
  const CheckedVolume volume = checked_volume(type, options);
  const std::lock_guard lock(mutex);
  const Kind kind = {volume.type, volume.kind, volume.preset, volume.max_error};
  const auto known = found.find(kind);
  if (known != found.end()) return known->second;
  return found.emplace(kind, check_of(volume)).first->second;
}

}  // namespace octavo
