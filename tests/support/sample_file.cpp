#include "support/sample_file.h"

#include <algorithm>
#include <cstring>

#include "octavo/core/crc32c.h"
#include "octavo/core/sha256.h"
#include "octavo/file/layer_order.h"

namespace octavo::testing {

namespace {

template <class T>
T sample_value(const Index3& p, const Size3& size, Pattern pattern, std::uint32_t& state) {
  state = state * 1664525u + 1013904223u;
  switch (pattern) {
    case Pattern::constant: return static_cast<T>(7);
    case Pattern::gradient: return static_cast<T>(p.x + 2 * p.y + 3 * p.z);
    case Pattern::noisy_half: break;
  }
  return p.z < size.z / 2 ? static_cast<T>(5) : static_cast<T>(20 + (state >> 24) % 50);
}

Size3 brick_size_at(const Levels& levels, int tier, const Index3& brick, int in_brick) {
  return brick_shape(levels, tier, brick).size[static_cast<std::size_t>(in_brick)];
}

std::size_t flat(const Size3& size, std::int64_t x, std::int64_t y, std::int64_t z) {
  return static_cast<std::size_t>((z * size.y + y) * size.x + x);
}

// One tier of a volume being written: the samples of its finest level and where things stand.
struct TierWork {
  SampleVolume& volume;
  int tier;

  int first_level() const { return Levels::first_level(tier); }
  std::size_t voxel_bytes() const {
    return static_cast<std::size_t>(bytes_per_voxel(volume.description.coded_type()));
  }
  Bytes& samples(int level) { return volume.samples[static_cast<std::size_t>(level)]; }

  BrickView view(const Index3& brick) {
    const Box box = volume.levels.brick_box(tier, brick);
    const Size3& size = volume.levels.size(first_level());
    BrickView result;
    result.voxels = samples(first_level()).data() +
                    flat(size, box.lo.x, box.lo.y, box.lo.z) * voxel_bytes();
    result.type = volume.description.coded_type();
    result.size = box.size();
    result.row_stride = size.x;
    result.plane_stride = size.x * size.y;
    return result;
  }

  // Decodes every in-brick level in memory and puts it where it belongs.
  void keep_levels(const BrickCodec& codec, const Index3& brick, const EncodedBrick& encoded) {
    const BrickShape shape = brick_shape(volume.levels, tier, brick);
    const std::vector<ByteSpan> spans(encoded.segments.begin(), encoded.segments.end());
    for (int i = 0; i < shape.level_count; ++i) {
      const int level = first_level() + i;
      const Size3 size = brick_size_at(volume.levels, tier, brick, i);
      Bytes decoded(static_cast<std::size_t>(size.voxel_count()) * voxel_bytes());
      if (encoded.range.min == encoded.range.max) {
        put_all(decoded, encoded.range.min);
      } else {
        codec.decode(shape, volume.description.coded_type(), encoded.range, spans, i,
                     decoded.data());
      }
      const Size3 side = brick_side_at(volume.levels, level);
      const Size3& all = volume.levels.size(level);
      for (std::int64_t z = 0; z < size.z; ++z) {
        for (std::int64_t y = 0; y < size.y; ++y) {
          const std::size_t to = flat(all, brick.x * side.x, brick.y * side.y + y,
                                      brick.z * side.z + z);
          std::memcpy(samples(level).data() + to * voxel_bytes(),
                      decoded.data() + flat(size, 0, y, z) * voxel_bytes(),
                      static_cast<std::size_t>(size.x) * voxel_bytes());
        }
      }
    }
  }

  void put_all(Bytes& bytes, std::int64_t value) const {
    for (std::size_t at = 0; at < bytes.size(); at += voxel_bytes()) {
      put_value(bytes.data() + at, value);
    }
  }

  void put_value(std::uint8_t* out, std::int64_t value) const {
    with_voxel_type(volume.description.coded_type(), [&](auto tag) {
      const auto v = static_cast<typename decltype(tag)::type>(value);
      std::memcpy(out, &v, sizeof v);
    });
  }
};

// Bricks of a lossy float sample tell half of the max error.
EncodedBrick with_error_steps(const SampleVolume& volume, int tier, EncodedBrick encoded) {
  constexpr std::int64_t kHalf = 512;
  encoded.max_error = tier == 0 && volume.max_error > 0 ? kHalf : 0;
  return encoded;
}

std::unique_ptr<BrickCodec> train_on_layer(TierWork& work, std::int64_t layer) {
  std::vector<TrainingBrick> bricks;
  for (Index3 brick : layer_order(work.volume.levels.brick_grid(0))) {
    brick.z = layer;
    bricks.push_back({brick_shape(work.volume.levels, 0, brick), work.view(brick)});
  }
  const VolumeDescription& description = work.volume.description;
  return train_model(description.kind, description.coded_type(), bricks,
                     {Preset::small, work.volume.codec_error, kStraightOrder});
}

}  // namespace

SampleVolume make_sample(const Size3& size, VoxelType type, Pattern pattern, VolumeKind kind) {
  SampleVolume volume;
  volume.description.kind = kind;
  volume.description.type = type;
  volume.description.size = size;
  volume.description.geometry.spacing_mm = {0.5, 0.5, 0.5};
  volume.description.metadata = Metadata::read(R"({"source":{"format":"test"}})");
  volume.levels = Levels(size, choose_halvings(size, volume.description.geometry.spacing_mm));
  for (int level = 0; level < volume.levels.count(); ++level) {
    volume.samples.emplace_back(static_cast<std::size_t>(
        volume.levels.size(level).voxel_count() * bytes_per_voxel(type)));
  }
  with_voxel_type(type, [&](auto tag) {
    using T = typename decltype(tag)::type;
    std::uint32_t state = 1;
    std::uint8_t* out = volume.samples[0].data();
    for (std::int64_t z = 0; z < size.z; ++z) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t x = 0; x < size.x; ++x, out += sizeof(T)) {
          const T value = sample_value<T>({x, y, z}, size, pattern, state);
          std::memcpy(out, &value, sizeof(T));
        }
      }
    }
  });
  return volume;
}

void write_sample(Storage& storage, const std::string& path, SampleVolume& volume,
                  bool overwrite) {
  WriterOptions options;
  options.overwrite = overwrite;
  options.max_error = volume.max_error;
  const auto writer = FileWriter::create(storage, path, volume.description, volume.levels,
                                         crc32c(volume.samples[0]), options);
  encode_sample(*writer, volume);
  writer->finish();
}

void encode_sample(FileWriter& writer, SampleVolume& volume) {
  std::unique_ptr<BrickCodec> first_codec;
  std::unique_ptr<BrickCodec> codec;
  for (int tier = 0; tier < volume.levels.tier_count(); ++tier) {
    TierWork work{volume, tier};
    if (tier == 1 && volume.codec_error > 0) {
      first_codec = train_model(volume.description.kind, volume.description.coded_type(), {});
      writer.add_model(first_codec->serialized());
    }
    const Size3 grid = volume.levels.brick_grid(tier);
    std::vector<std::pair<Index3, std::int64_t>> parents;
    for (std::int64_t layer = 0; layer < grid.z; ++layer) {
      if (tier == 0 && layer % volume.model_layers == 0) {
        if (layer > 0 && !first_codec) first_codec = std::move(codec);
        codec = train_on_layer(work, layer);
        if (volume.changed_codec) codec = volume.changed_codec(*codec);
        writer.add_model(codec->serialized());
      }
      const BrickCodec& used = tier > 0 && first_codec ? *first_codec : *codec;
      std::vector<EncodedBrick> encoded;
      for (Index3 brick : layer_order(grid)) {
        brick.z = layer;
        encoded.push_back(used.encode(brick_shape(volume.levels, tier, brick), work.view(brick)));
        work.keep_levels(used, brick, encoded.back());
        parents.emplace_back(brick, encoded.back().parent);
      }
      if (tier == 0) writer.add_plane_digests(sample_plane_digests(volume, layer));
      for (const EncodedBrick& brick : encoded) {
        writer.add_brick(tier, with_error_steps(volume, tier, brick));
      }
    }
    if (tier + 1 == volume.levels.tier_count()) continue;
    Bytes& above = work.samples(Levels::first_level(tier + 1));
    for (const auto& [brick, value] : parents) {
      work.put_value(above.data() + flat(grid, brick.x, brick.y, brick.z) * work.voxel_bytes(),
                     value + volume.parent_error);
    }
  }
}

std::vector<Sha256Digest> digests_of_planes(ByteSpan planes, std::size_t plane_count) {
  const std::size_t plane_bytes = planes.size() / plane_count;
  std::vector<Sha256Digest> digests;
  for (std::size_t z = 0; z < plane_count; ++z) {
    digests.push_back(sha256(planes.subspan(z * plane_bytes, plane_bytes)));
  }
  return digests;
}

std::vector<Sha256Digest> sample_plane_digests(const SampleVolume& volume, std::int64_t layer) {
  Box planes = volume.levels.brick_box(0, {0, 0, layer});
  planes.hi.x = volume.description.size.x;
  planes.hi.y = volume.description.size.y;
  const auto plane_count = static_cast<std::size_t>(planes.size().z);
  const auto voxel_count = static_cast<std::size_t>(planes.size().voxel_count());
  const auto width = static_cast<std::size_t>(bytes_per_voxel(volume.description.coded_type()));
  const auto first = static_cast<std::size_t>(planes.lo.z) * (voxel_count / plane_count);
  const ByteSpan codes =
      ByteSpan(volume.samples[0]).subspan(first * width, voxel_count * width);
  if (!volume.description.coding) return digests_of_planes(codes, plane_count);
  Bytes voxels(voxel_count * sizeof(float));
  decode_samples(*volume.description.coding, codes.data(),
                 {reinterpret_cast<float*>(voxels.data()), voxel_count});
  return digests_of_planes(voxels, plane_count);
}

SampleVolume make_lossy_float_sample() {
  SampleVolume volume = make_sample({66, 20, 70}, VoxelType::uint8, Pattern::noisy_half);
  volume.description.type = VoxelType::float32;
  volume.description.coding = SampleCoding{VoxelType::uint8, 0.5, -1};
  volume.codec_error = 3;
  volume.max_error = 1.5;
  return volume;
}

std::vector<std::uint8_t> sample_file_bytes(SampleVolume& volume) {
  MemoryStorage storage;
  write_sample(storage, "sample.8vo", volume);
  return *storage.files.at("sample.8vo");
}

std::shared_ptr<FileReader> open_bytes(std::vector<std::uint8_t> bytes) {
  return FileReader::open(byte_source_of(std::move(bytes), "sample.8vo"));
}

Bytes expected_samples(const SampleVolume& volume, const Box& box, int level) {
  const auto voxel_bytes = static_cast<std::size_t>(bytes_per_voxel(volume.description.type));
  const Bytes& all = volume.samples[static_cast<std::size_t>(level)];
  const Size3& size = volume.levels.size(level);
  Bytes result;
  for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      const auto from =
          all.begin() + static_cast<std::ptrdiff_t>(flat(size, box.lo.x, y, z) * voxel_bytes);
      const auto row = static_cast<std::ptrdiff_t>(
          static_cast<std::size_t>(box.size().x) * voxel_bytes);
      result.insert(result.end(), from, from + row);
    }
  }
  return result;
}

Bytes read_samples(const FileReader& reader, const Box& box, int level) {
  Bytes out(static_cast<std::size_t>(box.size().voxel_count() *
                                     bytes_per_voxel(reader.description().type)));
  reader.read(box, level, out.data());
  return out;
}

}  // namespace octavo::testing
