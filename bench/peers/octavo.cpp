// Octavo beside its peers: the brick codec on bricks in memory, and a whole file built and read.

#include <unistd.h>

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <span>

#include "bench/peers/peer.h"
#include "octavo/builder/builder.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/core/error.h"
#include "octavo/file/reader.h"
#include "octavo/file/storage/storage.h"

namespace octavo::bench {
namespace {

Levels levels_of(const RawVolume& volume) {
  return Levels(volume.size, choose_halvings(volume.size, volume.spacing_mm));
}

/// The bricks of the scan itself, layer by layer.
std::vector<Index3> bricks_of(const Levels& levels) {
  const Size3 grid = levels.brick_grid(0);
  std::vector<Index3> bricks;
  for (std::int64_t z = 0; z < grid.z; ++z) {
    for (std::int64_t y = 0; y < grid.y; ++y) {
      for (std::int64_t x = 0; x < grid.x; ++x) bricks.push_back({x, y, z});
    }
  }
  return bricks;
}

BrickView view_of(const RawVolume& volume, const Box& box) {
  const std::int64_t first =
      (box.lo.z * volume.size.y + box.lo.y) * volume.size.x + box.lo.x;
  return {volume.voxels.data() + first * volume.voxel_bytes(), volume.type, box.size(),
          volume.size.x, volume.size.x * volume.size.y};
}

const char* name_of(Preset preset) { return preset == Preset::small ? "small" : "fast"; }

/// Labels have one preset and no error.
bool kind_has(VolumeKind kind, const CodecSettings& settings) {
  return kind == VolumeKind::grey ||
         (settings.preset == Preset::small && settings.max_error == 0);
}

/// One model for the volume, trained on bricks spread over it; every brick of tier 0 in memory.
class Bricks final : public Peer {
 public:
  explicit Bricks(const CodecSettings& settings) : settings_(settings) {}
  std::string name() const override {
    return std::string("octavo-bricks-") + name_of(settings_.preset);
  }
  bool supports(const RawVolume& volume) const override {
    return kind_has(volume.kind, settings_);
  }

  Encoded encode(const RawVolume& volume) override {
    const Levels levels = levels_of(volume);
    const std::vector<Index3> bricks = bricks_of(levels);
    const auto codec =
        train_model(volume.kind, volume.type, samples(volume, levels, bricks), settings_);
    Encoded encoded;
    encoded.pieces.push_back(codec->serialized());
    ranges_.clear();
    for (const Index3& brick : bricks) {
      const EncodedBrick result = codec->encode(brick_shape(levels, 0, brick),
                                                view_of(volume, levels.brick_box(0, brick)));
      ranges_.push_back(result.range);
      for (const Bytes& segment : result.segments) {
        if (!segment.empty()) encoded.extra_bytes += kChecksumBytes;
        encoded.pieces.push_back(segment);
      }
    }
    return encoded;
  }

  void decode(const Encoded& encoded, RawVolume& volume) override {
    const Levels levels = levels_of(volume);
    const auto codec = parse_model(volume.kind, volume.type, encoded.pieces[0]);
    Bytes dense;
    std::size_t next = 1, index = 0;
    for (const Index3& brick : bricks_of(levels)) {
      const BrickShape shape = brick_shape(levels, 0, brick);
      std::vector<ByteSpan> segments;
      for (int i = 0; i < shape.level_count; ++i) segments.emplace_back(encoded.pieces[next++]);
      const ValueRange range = ranges_[index++];
      dense.resize(static_cast<std::size_t>(shape.size[0].voxel_count() * volume.voxel_bytes()));
      if (range.min == range.max) {
        fill(dense, volume.type, range.min);
      } else {
        codec->decode(shape, volume.type, range, segments, 0, dense.data());
      }
      put(volume, levels.brick_box(0, brick), dense);
    }
  }

 private:
  static constexpr std::size_t kChecksumBytes = 4;
  static constexpr std::size_t kMaxTrainingBricks = 32;

  static std::vector<TrainingBrick> samples(const RawVolume& volume, const Levels& levels,
                                            const std::vector<Index3>& bricks) {
    std::vector<Index3> uneven;
    for (const Index3& brick : bricks) {
      if (!is_uniform(volume, levels.brick_box(0, brick))) uneven.push_back(brick);
    }
    std::vector<TrainingBrick> training;
    const std::size_t count = std::min(kMaxTrainingBricks, uneven.size());
    for (std::size_t i = 0; i < count; ++i) {
      const Index3& brick = uneven[(2 * i + 1) * uneven.size() / (2 * count)];
      training.push_back({brick_shape(levels, 0, brick),
                          view_of(volume, levels.brick_box(0, brick))});
    }
    return training;
  }

  static bool is_uniform(const RawVolume& volume, const Box& box) {
    const auto voxel_bytes = static_cast<std::size_t>(volume.voxel_bytes());
    const auto row = static_cast<std::size_t>(box.size().x) * voxel_bytes;
    const std::uint8_t* first = row_at(volume, box, box.lo.y, box.lo.z);
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        const std::uint8_t* voxels = row_at(volume, box, y, z);
        if (std::memcmp(voxels, first, voxel_bytes) != 0 ||
            std::memcmp(voxels, voxels + voxel_bytes, row - voxel_bytes) != 0) {
          return false;
        }
      }
    }
    return true;
  }

  static const std::uint8_t* row_at(const RawVolume& volume, const Box& box, std::int64_t y,
                                    std::int64_t z) {
    return volume.voxels.data() +
           ((z * volume.size.y + y) * volume.size.x + box.lo.x) * volume.voxel_bytes();
  }

  static void fill(Bytes& dense, VoxelType type, std::int64_t value) {
    with_voxel_type(type, [&]<class T>(std::type_identity<T>) {
      const auto voxel = static_cast<T>(value);
      for (std::size_t at = 0; at < dense.size(); at += sizeof(T)) {
        std::memcpy(dense.data() + at, &voxel, sizeof(T));
      }
    });
  }

  static void put(RawVolume& volume, const Box& box, const Bytes& dense) {
    const auto row = static_cast<std::size_t>(box.size().x * volume.voxel_bytes());
    const std::uint8_t* from = dense.data();
    for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y, from += row) {
        const std::int64_t voxel = (z * volume.size.y + y) * volume.size.x + box.lo.x;
        std::memcpy(volume.voxels.data() + voxel * volume.voxel_bytes(), from, row);
      }
    }
  }

  CodecSettings settings_;
  std::vector<ValueRange> ranges_;
};

/// Planes out of a volume in memory.
class VolumePlanes final : public PlaneSource {
 public:
  explicit VolumePlanes(const RawVolume& volume) : volume_(volume) {
    description_.kind = volume.kind;
    description_.type = volume.type;
    description_.size = volume.size;
    description_.geometry.spacing_mm = volume.spacing_mm;
  }
  const VolumeDescription& description() const override { return description_; }
  const std::vector<Warning>& warnings() const override { return warnings_; }
  void read_plane(std::span<std::byte> plane) override {
    std::memcpy(plane.data(), volume_.voxels.data() + next_++ * volume_.plane_bytes(),
                plane.size());
  }
  void seek(std::int64_t first, std::int64_t) override { next_ = first; }

 private:
  const RawVolume& volume_;
  VolumeDescription description_;
  std::vector<Warning> warnings_;
  std::int64_t next_ = 0;
};

/// A whole file through the builder on one thread (every brick decoded again and compared), then
/// all of level 0 read through the reader on one thread.
class WholeFile final : public Peer {
 public:
  explicit WholeFile(const CodecSettings& settings)
      : settings_(settings),
        path_(std::filesystem::temp_directory_path() /
              ("octavo-bench-" + std::to_string(getpid()) + "-" + name_of(settings.preset) +
               ".8vo")) {}
  ~WholeFile() override {
    std::error_code ignored;
    std::filesystem::remove(path_, ignored);
  }
  std::string name() const override {
    return std::string("octavo-file-") + name_of(settings_.preset);
  }
  bool supports(const RawVolume& volume) const override {
    return kind_has(volume.kind, settings_);
  }

  Encoded encode(const RawVolume& volume) override {
    VolumePlanes planes(volume);
    BuildOptions options;
    options.kind = volume.kind;
    options.overwrite = true;
    options.threads = 1;
    options.preset = settings_.preset;
    options.max_error = static_cast<double>(settings_.max_error);
    NoProgress progress;
    return {{}, build_file(planes, local_storage(), path_, options, progress).file_bytes};
  }

  void decode(const Encoded&, RawVolume& volume) override {
    const auto reader = FileReader::open(open_byte_source(local_storage(), path_));
    reader->read(box_of(volume.size), 0, volume.voxels.data());
  }

 private:
  CodecSettings settings_;
  std::string path_;
};

}  // namespace

void add_octavo_peers(Peers& peers, std::int64_t max_error) {
  for (const Preset preset : {Preset::small, Preset::fast}) {
    const CodecSettings settings{preset, max_error};
    peers.push_back(std::make_unique<Bricks>(settings));
    peers.push_back(std::make_unique<WholeFile>(settings));
  }
}

}  // namespace octavo::bench
