#include "octavo/io/source/streamed_source.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 16;

class StreamedSource final : public DescribedSource {
 public:
  StreamedSource(SourceFacts facts, const VoxelRun& run)
      : DescribedSource(std::move(facts)),
        run_(run),
        swap_(needs_swap(run.big_endian)),
        stream_(run.path, run.start_offset, run.coding) {
    stream_.skip(run.skip_bytes);
  }

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const std::int64_t z = take_plane_index();
    const auto value_bytes = static_cast<std::size_t>(bytes_per_voxel(description().type));
    if (run_.values_per_voxel == 1) {
      stream_.read(plane);
    } else {
      read_one_of_several(plane, value_bytes);
    }
    if (swap_) swap_values(plane, value_bytes);
    const bool is_last = z + 1 == description().size.z;
    if (is_last && run_.coding != StreamCoding::plain) prove_end();
  }

 private:
  void read_one_of_several(std::span<std::byte> plane, std::size_t value_bytes) {
    const std::size_t voxel_bytes = value_bytes * static_cast<std::size_t>(run_.values_per_voxel);
    const Alternation one = {value_bytes, run_.values_per_voxel, run_.value_index};
    const std::size_t chunk_voxels = std::max<std::size_t>(kChunkBytes / voxel_bytes, 1);
    std::vector<std::byte> chunk(chunk_voxels * voxel_bytes);
    for (std::size_t at = 0; at < plane.size();) {
      const std::size_t count = std::min(chunk_voxels, (plane.size() - at) / value_bytes);
      stream_.read(std::span(chunk).first(count * voxel_bytes));
      take_alternating(one, chunk, plane.subspan(at, count * value_bytes));
      at += count * value_bytes;
    }
  }

  void prove_end() {
    stream_.skip(run_.bytes_behind);
    if (const std::uint64_t left = stream_.finish(); left > 0) {
      warn(std::to_string(left) + " bytes behind the voxels were left out: " +
           escaped(stream_.path()));
    }
  }

  VoxelRun run_;
  bool swap_;
  VoxelStream stream_;
};

/// Proves that a plain file holds all voxels.
void check_plain_length(SourceFacts& facts, const VoxelRun& run, std::uint64_t voxel_bytes) {
  const SourceFile file(run.path);
  const std::uint64_t start = checked_add(run.start_offset, run.skip_bytes, "voxel offset");
  const std::uint64_t needed = checked_add(start, voxel_bytes, "file length");
  const std::string channels =
      run.values_per_voxel == 1 ? "" : std::to_string(run.values_per_voxel) + " channels of ";
  if (file.size() < needed) {
    throw Error(ErrorKind::source_rejected,
                "the file is too short: " + std::to_string(needed) + " bytes needed for " +
                    size_text(facts.description.size) + " voxels of " + channels +
                    std::string(voxel_type_name(facts.description.type)) + ", " +
                    std::to_string(file.size()) + " found; it is cut or its header is wrong",
                run.path, file.size());
  }
  if (file.size() > needed) {
    facts.warnings.push_back(std::to_string(file.size() - needed) +
                             " bytes behind the voxels were left out: " + escaped(run.path));
  }
}

}  // namespace

void VoxelRun::take_volume(std::int64_t index, std::int64_t count, std::uint64_t volume_bytes) {
  const std::uint64_t one =
      checked_mul(volume_bytes, static_cast<std::uint64_t>(values_per_voxel), "volume");
  const std::uint64_t before = checked_mul(one, static_cast<std::uint64_t>(index), "volumes");
  skip_bytes = checked_add(skip_bytes, before, "voxel offset");
  bytes_behind = checked_mul(one, static_cast<std::uint64_t>(count - 1 - index), "volumes");
}

std::unique_ptr<PlaneSource> make_streamed_source(SourceFacts facts, const VoxelRun& run) {
  const std::uint64_t volume_bytes = checked_mul(
      checked_mul(plane_bytes(facts.description),
                  static_cast<std::uint64_t>(facts.description.size.z), "volume"),
      static_cast<std::uint64_t>(run.values_per_voxel), "volume");
  const std::uint64_t voxel_bytes = checked_add(volume_bytes, run.bytes_behind, "volumes");
  if (run.coding == StreamCoding::plain) {
    check_plain_length(facts, run, voxel_bytes);
  } else if (run.start_offset == 0 && is_gzip_file(run.path)) {
    check_gzip_length(run.path, checked_add(run.skip_bytes, voxel_bytes, "stream length"));
  }
  return std::make_unique<StreamedSource>(std::move(facts), run);
}

}  // namespace octavo
