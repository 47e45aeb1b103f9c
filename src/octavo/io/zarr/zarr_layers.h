// Layers of chunks of an array of zarr, unpacked: the planes of one channel and time.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/box.h"
#include "octavo/core/error.h"
#include "octavo/io/zarr/zarr_hierarchy.h"
#include "octavo/io/zarr/zarr_layout.h"

namespace octavo {

/// Which part of an array is the volume.
struct ZarrPart {
  std::size_t z = 0;  ///< axes of the array
  std::size_t y = 0;
  std::size_t x = 0;
  std::vector<std::int64_t> at;  ///< of each axis; of these three nothing
};

/// Gives planes of stored numbers in native byte order. One thread at a time.
class ZarrLayers {
 public:
  /// folder   of the array in the hierarchy; empty where it is all of it
  /// threads  that unpack chunks side by side, made for each layer: those of a task arena may wait
  ///          for a plane themselves
  ZarrLayers(std::shared_ptr<const ZarrHierarchy> hierarchy, std::string folder,
             ZarrLayout layout, ZarrPart part, int threads);

  Size3 size() const;
  /// Bytes of a layer.
  std::uint64_t layer_bytes() const;
  /// Fills `plane` with plane z. Throws Error{source_rejected} naming the file, Error{io}
  void read(std::int64_t z, std::span<std::byte> plane);

 private:
  /// Offset and length of each chunk of a shard; empty where there is no such file.
  using ShardIndex = std::vector<std::uint64_t>;

  void fill_layer(std::int64_t layer);
  void take_chunk(std::int64_t layer, std::int64_t y, std::int64_t x);
  Error located(const Error& failure, std::vector<std::int64_t> chunk) const;
  std::optional<ZarrFile> open_file(const std::vector<std::int64_t>& place) const;
  std::optional<std::vector<std::uint8_t>> packed(const std::vector<std::int64_t>& chunk);
  std::shared_ptr<const ShardIndex> shard_at(const std::vector<std::int64_t>& place);
  ShardIndex read_index(const std::vector<std::int64_t>& place) const;
  /// A voxel of a plane of the layer.
  std::byte* row_at(std::int64_t x, std::int64_t y, std::int64_t plane);
  void fill(const Box& box);
  void copy(const std::vector<std::uint8_t>& chunk, const Box& box);

  std::shared_ptr<const ZarrHierarchy> hierarchy_;
  std::string folder_;
  ZarrLayout layout_;
  ZarrPart part_;
  int threads_;
  std::int64_t held_ = -1;  ///< number of the layer in voxels_
  std::vector<std::byte> voxels_;
  std::mutex lock_;  ///< of shards_
  std::int64_t shard_layer_ = -1;  ///< that shards_ are of
  std::map<std::vector<std::int64_t>, std::shared_ptr<const ShardIndex>> shards_;
};

}  // namespace octavo
