#include "octavo/io/zarr/zarr_layers.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "octavo/core/checked.h"
#include "octavo/core/crc32c.h"
#include "octavo/file/byte_codec.h"
#include "octavo/io/source/header_bytes.h"
#include "octavo/io/source/own_threads.h"
#include "octavo/io/zarr/zarr_chunk.h"

namespace octavo {

namespace {

constexpr std::uint64_t kLeftOutChunk = ~std::uint64_t{0};
/// What a file of a chunk may have beyond the chunk itself: heads of blocks and of streams.
constexpr std::uint64_t kMostHeadBytes = std::uint64_t{1} << 20;

std::int64_t count_of(std::int64_t length, std::int64_t side) {
  return (length - 1) / side + 1;
}

}  // namespace

ZarrLayers::ZarrLayers(std::shared_ptr<const ZarrHierarchy> hierarchy, std::string folder,
                       ZarrLayout layout, ZarrPart part, int threads)
    : hierarchy_(std::move(hierarchy)),
      folder_(std::move(folder)),
      layout_(std::move(layout)),
      part_(std::move(part)),
      threads_(threads) {}

Size3 ZarrLayers::size() const {
  return {layout_.shape[part_.x], layout_.shape[part_.y], layout_.shape[part_.z]};
}

std::uint64_t ZarrLayers::layer_bytes() const {
  const std::int64_t planes = std::min(layout_.chunk[part_.z], size().z);
  const std::uint64_t plane = checked_mul(static_cast<std::uint64_t>(size().x),
                                          static_cast<std::uint64_t>(size().y), "a plane");
  return checked_mul(checked_mul(plane, static_cast<std::uint64_t>(planes), "a layer of chunks"),
                     bytes_per_value(layout_.type), "a layer of chunks");
}

void ZarrLayers::read(std::int64_t z, std::span<std::byte> plane) {
  const std::int64_t side = layout_.chunk[part_.z];
  if (held_ != z / side) fill_layer(z / side);
  std::memcpy(plane.data(), voxels_.data() + static_cast<std::size_t>(z % side) * plane.size(),
              plane.size());
}

void ZarrLayers::fill_layer(std::int64_t layer) {
  held_ = -1;  // should it fail
  voxels_.resize(static_cast<std::size_t>(layer_bytes()));
  const std::int64_t columns = count_of(size().x, layout_.chunk[part_.x]);
  const std::int64_t rows = count_of(size().y, layout_.chunk[part_.y]);
  if (layout_.sharding) {
    const std::int64_t shard = layer / layout_.sharding->chunks[part_.z];
    if (shard != shard_layer_) shards_.clear();
    shard_layer_ = shard;
  }
  on_own_threads(static_cast<std::size_t>(rows * columns), static_cast<std::size_t>(threads_),
                 [&](std::size_t i) {
                   const auto chunk = static_cast<std::int64_t>(i);
                   take_chunk(layer, chunk / columns, chunk % columns);
                 });
  held_ = layer;
}

void ZarrLayers::take_chunk(std::int64_t layer, std::int64_t y, std::int64_t x) {
  std::vector<std::int64_t> place(layout_.dimensions());
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    place[axis] = part_.at[axis] / layout_.chunk[axis];
  }
  place[part_.z] = layer;
  place[part_.y] = y;
  place[part_.x] = x;
  const Size3 side{layout_.chunk[part_.x], layout_.chunk[part_.y], layout_.chunk[part_.z]};
  const Box box = intersection(
      box_of(size()), moved(box_of(side), {x * side.x, y * side.y, layer * side.z}));
  std::optional<std::vector<std::uint8_t>> bytes = packed(place);
  if (!bytes) return fill(box);
  try {
    copy(unpacked_chunk(std::move(*bytes), layout_), box);
  } catch (const Error& failure) {
    throw located(failure, place);
  }
}

/// With the file, and with the place in it where others stand there as well.
Error ZarrLayers::located(const Error& failure, std::vector<std::int64_t> chunk) const {
  std::string which;
  if (layout_.sharding) {
    which = "chunk ";
    for (std::size_t axis = 0; axis < chunk.size(); ++axis) {
      const std::int64_t side = layout_.sharding->chunks[axis];
      which += (axis == 0 ? "" : "/") + std::to_string(chunk[axis] % side);
      chunk[axis] /= side;
    }
    which += " of the shard: ";
  }
  return failure.with_detail(which + failure.detail())
      .with_path(hierarchy_->path() + "/" + key_in(folder_, layout_.keys.key_of(chunk)));
}

std::optional<ZarrFile> ZarrLayers::open_file(const std::vector<std::int64_t>& place) const {
  return hierarchy_->open(key_in(folder_, layout_.keys.key_of(place)));
}

std::optional<std::vector<std::uint8_t>> ZarrLayers::packed(
    const std::vector<std::int64_t>& chunk) {
  const std::uint64_t most = 2 * layout_.chunk_bytes() + kMostHeadBytes;
  const auto require = [&](const ZarrFile& file, std::uint64_t length) {
    if (length <= most) return;
    reject(file.path(), std::to_string(length) + " bytes are too many for a chunk of " +
                            std::to_string(layout_.chunk_bytes()));
  };
  if (!layout_.sharding) {
    const std::optional<ZarrFile> file = open_file(chunk);
    if (!file) return std::nullopt;
    require(*file, file->size());
    return file->read(0, file->size());
  }
  std::vector<std::int64_t> place = chunk;
  std::uint64_t number = 0;
  for (std::size_t axis = 0; axis < place.size(); ++axis) {
    const std::int64_t side = layout_.sharding->chunks[axis];
    number = number * static_cast<std::uint64_t>(side) +
             static_cast<std::uint64_t>(place[axis] % side);
    place[axis] /= side;
  }
  const std::shared_ptr<const ShardIndex> index = shard_at(place);
  if (index->empty()) return std::nullopt;
  const std::uint64_t offset = (*index)[static_cast<std::size_t>(2 * number)];
  const std::uint64_t length = (*index)[static_cast<std::size_t>(2 * number + 1)];
  if (offset == kLeftOutChunk && length == kLeftOutChunk) return std::nullopt;
  // Opened anew each time: a layer may lie in more shards than a process may have files open.
  const std::optional<ZarrFile> file = open_file(place);
  if (!file) return std::nullopt;
  require(*file, length);
  return file->read(offset, length);
}

std::shared_ptr<const ZarrLayers::ShardIndex> ZarrLayers::shard_at(
    const std::vector<std::int64_t>& place) {
  const std::lock_guard guard(lock_);
  std::shared_ptr<const ShardIndex>& shard = shards_[place];
  if (!shard) shard = std::make_shared<const ShardIndex>(read_index(place));
  return shard;
}

ZarrLayers::ShardIndex ZarrLayers::read_index(const std::vector<std::int64_t>& place) const {
  const ZarrSharding& sharding = *layout_.sharding;
  const std::optional<ZarrFile> file = open_file(place);
  if (!file) return {};
  const std::uint64_t bytes = sharding.index_bytes();
  const std::string& path = file->path();
  if (file->size() < bytes) {
    reject(path, "the shard is shorter than its index of " + std::to_string(bytes) + " bytes");
  }
  const std::vector<std::uint8_t> written =
      file->read(sharding.is_index_at_start ? 0 : file->size() - bytes, bytes);
  const std::size_t numbers = static_cast<std::size_t>(2 * sharding.chunk_count());
  if (sharding.has_index_checksum) {
    const auto stored = load_little_endian<std::uint32_t>(written.data() + 8 * numbers);
    if (!checksum_matches(crc32c(std::span(written).first(8 * numbers)), stored)) {
      reject(path, "the checksum of the index of the shard is wrong");
    }
  }
  ShardIndex index(numbers);
  HeaderBytes(std::as_bytes(std::span(written)), sharding.is_index_big_endian)
      .fill<std::uint64_t>(0, index);
  return index;
}

std::byte* ZarrLayers::row_at(std::int64_t x, std::int64_t y, std::int64_t plane) {
  const Size3 all = size();
  return voxels_.data() + static_cast<std::size_t>((plane * all.y + y) * all.x + x) *
                              bytes_per_value(layout_.type);
}

/// What lies in `box` of the volume, where its chunk is not there.
void ZarrLayers::fill(const Box& box) {
  const std::size_t value = bytes_per_value(layout_.type);
  std::vector<std::byte> row(static_cast<std::size_t>(box.size().x) * value);
  for (std::size_t at = 0; at < row.size(); at += value) {
    std::memcpy(row.data() + at, layout_.fill.data(), value);
  }
  for (std::int64_t plane = 0; plane < box.size().z; ++plane) {
    for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
      std::memcpy(row_at(box.lo.x, y, plane), row.data(), row.size());
    }
  }
}

/// Puts what lies in `box` of the volume into the layer.
void ZarrLayers::copy(const std::vector<std::uint8_t>& chunk, const Box& box) {
  // How many values stand between neighbors along each axis of the chunk.
  std::vector<std::int64_t> step(layout_.dimensions());
  std::int64_t values = 1;
  for (std::size_t i = layout_.dimensions(); i-- > 0;) {
    const std::size_t axis = layout_.codecs.order[i];
    step[axis] = values;
    values *= layout_.chunk[axis];
  }
  std::int64_t start = 0;
  for (std::size_t axis = 0; axis < step.size(); ++axis) {
    start += part_.at[axis] % layout_.chunk[axis] * step[axis];
  }
  const std::size_t value = bytes_per_value(layout_.type);
  const Size3 part = box.size();
  const auto row_bytes = static_cast<std::size_t>(part.x) * value;
  for (std::int64_t z = 0; z < part.z; ++z) {
    for (std::int64_t y = 0; y < part.y; ++y) {
      const std::uint8_t* from =
          chunk.data() +
          static_cast<std::size_t>(start + z * step[part_.z] + y * step[part_.y]) * value;
      std::byte* to = row_at(box.lo.x, box.lo.y + y, z);
      if (step[part_.x] == 1) {
        std::memcpy(to, from, row_bytes);
        continue;
      }
      for (std::int64_t x = 0; x < part.x; ++x) {
        std::memcpy(to + static_cast<std::size_t>(x) * value,
                    from + static_cast<std::size_t>(x * step[part_.x]) * value, value);
      }
    }
  }
}

}  // namespace octavo
