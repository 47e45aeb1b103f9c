#include "octavo/io/zarr/zarr_export.h"

#include <algorithm>
#include <cstring>
#include <memory>
#include <utility>
#include <vector>

#include "octavo/core/error.h"
#include "octavo/core/path_text.h"
#include "octavo/file/parallel_read.h"
#include "octavo/io/source/source_file.h"
#include "octavo/io/zarr/zarr_shard.h"
#include "octavo/threads/arena.h"
#include "octavo/threads/parallel_for.h"

namespace octavo {

namespace {

std::int64_t shares(std::int64_t length, std::int64_t side) { return (length + side - 1) / side; }

void require_side(std::int64_t value, std::int64_t lowest, std::int64_t highest,
                  const char* what) {
  if (value >= lowest && value <= highest) return;
  throw Error(ErrorKind::invalid_argument,
              std::string(what) + " must be " + std::to_string(lowest) + " to " +
                  std::to_string(highest));
}

ZarrGrid grid_of(const Size3& size, const ZarrExportOptions& options) {
  const std::int64_t side = options.chunk_side;
  const auto chunks = [&](std::int64_t length) {
    return std::min(options.shard_chunks, shares(length, side));
  };
  return {{side, side, side},
          Size3{chunks(size.x), chunks(size.y), chunks(size.z)},
          options.compression,
          true};
}

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

/// Writes the shards of one level, one after the other; chunks of each side by side.
class LevelShards {
 public:
  LevelShards(const FileReader& reader, int level, const ZarrGrid& grid, int threads)
      : reader_(reader),
        level_(level),
        grid_(grid),
        threads_(threads),
        size_(reader.levels().size(level)),
        voxel_bytes_(static_cast<std::size_t>(bytes_per_voxel(reader.description().type))) {}

  std::uint64_t write(const std::string& folder, ZarrOutput& output, Progress& progress) {
    const Size3 side = grid_.file_size();
    std::uint64_t files = 0;
    for (std::int64_t z = 0; z < shares(size_.z, side.z); ++z) {
      for (std::int64_t y = 0; y < shares(size_.y, side.y); ++y) {
        for (std::int64_t x = 0; x < shares(size_.x, side.x); ++x) {
          if (progress.is_cancelled()) throw Error(ErrorKind::cancelled, "stopped");
          const std::vector<std::uint8_t> shard = packed({x * side.x, y * side.y, z * side.z});
          if (shard.empty()) continue;
          output.put(folder + "/c/" + std::to_string(z) + "/" + std::to_string(y) + "/" +
                         std::to_string(x),
                     shard);
          ++files;
        }
      }
      progress.advance(std::min(side.z, size_.z - z * side.z));
    }
    return files;
  }

 private:
  std::vector<std::uint8_t> packed(const Index3& start) {
    const Size3 side = grid_.file_size();
    const Box box{start,
                  {std::min(start.x + side.x, size_.x), std::min(start.y + side.y, size_.y),
                   std::min(start.z + side.z, size_.z)}};
    voxels_.resize(static_cast<std::size_t>(box.size().voxel_count()) * voxel_bytes_);
    read_parallel(reader_, box, level_, voxels_.data(), threads_);
    const Size3 counts = *grid_.shard_chunks;
    std::vector<std::vector<std::uint8_t>> chunks(static_cast<std::size_t>(counts.voxel_count()));
    parallel_for(std::size_t{0}, chunks.size(), [&](std::size_t i) {
      const auto number = static_cast<std::int64_t>(i);
      const Index3 at{number % counts.x, number / counts.x % counts.y,
                      number / (counts.x * counts.y)};
      chunks[i] = packed_at(at, box.size());
    });
    return shard_of(chunks);
  }

  /// A chunk of the shard; empty where all its voxels are 0.
  std::vector<std::uint8_t> packed_at(const Index3& at, const Size3& shard) const {
    const Size3& side = grid_.chunk;
    const Index3 lo{at.x * side.x, at.y * side.y, at.z * side.z};
    const Index3 hi{std::min(lo.x + side.x, shard.x), std::min(lo.y + side.y, shard.y),
                    std::min(lo.z + side.z, shard.z)};
    if (lo.x >= hi.x || lo.y >= hi.y || lo.z >= hi.z) return {};
    std::vector<std::uint8_t> chunk(static_cast<std::size_t>(side.voxel_count()) * voxel_bytes_);
    const std::size_t row = static_cast<std::size_t>(hi.x - lo.x) * voxel_bytes_;
    for (std::int64_t z = lo.z; z < hi.z; ++z) {
      for (std::int64_t y = lo.y; y < hi.y; ++y) {
        const std::int64_t from = (z * shard.y + y) * shard.x + lo.x;
        const std::int64_t to = ((z - lo.z) * side.y + y - lo.y) * side.x;
        std::memcpy(chunk.data() + static_cast<std::size_t>(to) * voxel_bytes_,
                    voxels_.data() + static_cast<std::size_t>(from) * voxel_bytes_, row);
      }
    }
    if (std::all_of(chunk.begin(), chunk.end(), [](std::uint8_t byte) { return byte == 0; })) {
      return {};
    }
    std::vector<std::uint8_t> packed =
        packed_chunk(chunk, reader_.description().type, grid_.compression);
    if (grid_.compression == ZarrCompression::zstd) return packed;  // which has its own
    return with_checksum(std::move(packed));
  }

  const FileReader& reader_;
  int level_;
  ZarrGrid grid_;
  int threads_;
  Size3 size_;
  std::size_t voxel_bytes_;
  std::vector<std::uint8_t> voxels_;
};

std::string image_name(const std::string& path) {
  const std::string name = base_name(path);
  return name.substr(0, name.find('.'));
}

ZarrExportResult write_zarr(const FileReader& reader, const std::string& path, ZarrOutput& output,
                            const ZarrExportOptions& options, Progress& progress) {
  const Levels& levels = reader.levels();
  std::int64_t planes = 0;
  for (int level = options.first_level; level < levels.count(); ++level) {
    planes += levels.size(level).z;
  }
  const ProgressScope scope(progress, "exporting", planes, "planes");
  ZarrExportResult result;
  // All text stands before the voxels, so that whoever has the beginning of a zip file has it.
  output.put("zarr.json", bytes_of(ome_group_text(reader, options.first_level, levels.count(),
                                                  image_name(path))));
  for (int level = options.first_level; level < levels.count(); ++level) {
    const ZarrGrid grid = grid_of(levels.size(level), options);
    output.put(std::to_string(result.levels++) + "/zarr.json",
               bytes_of(zarr_array_text(reader.description().type, levels.size(level), grid)));
  }
  result.files = static_cast<std::uint64_t>(result.levels) + 1;
  for (int level = options.first_level; level < levels.count(); ++level) {
    LevelShards shards(reader, level, grid_of(levels.size(level), options), options.threads);
    result.files += shards.write(std::to_string(level - options.first_level), output, progress);
  }
  output.finish();
  result.bytes = output.bytes();
  return result;
}

}  // namespace

bool is_zarr_path(const std::string& path) {
  const std::string bare = without_end_slashes(path);
  return has_ending(bare, ".zarr") || has_ending(bare, ".ozx");
}

ZarrExportResult export_zarr(const FileReader& reader, Storage& storage, const std::string& path,
                             const ZarrExportOptions& options, Progress& progress) {
  if (options.first_level < 0 || options.first_level >= reader.levels().count()) {
    throw Error(ErrorKind::invalid_argument,
                "level " + std::to_string(options.first_level) + " is not there: levels are 0 to " +
                    std::to_string(reader.levels().count() - 1))
        .with_field("level");
  }
  require_side(options.chunk_side, 16, 256, "the side of chunks");
  require_side(options.shard_chunks, 1, 16, "chunks along a side of a shard");
  const std::string bare = without_end_slashes(path);
  const auto output = has_ending(bare, ".ozx")
                          ? make_zarr_zip(storage, bare, options.overwrite)
                          : make_zarr_folder(storage, bare, options.overwrite);
  ZarrExportResult result;
  run_in_arena(options.threads,
               [&] { result = write_zarr(reader, bare, *output, options, progress); });
  return result;
}

}  // namespace octavo
