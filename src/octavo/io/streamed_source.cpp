#include "octavo/io/streamed_source.h"

#include <utility>

#include "octavo/core/checked.h"
#include "octavo/io/byte_order.h"
#include "octavo/io/source_file.h"

namespace octavo {

namespace {

class StreamedSource final : public DescribedSource {
 public:
  StreamedSource(SourceFacts facts, const VoxelRun& run)
      : DescribedSource(std::move(facts)),
        coding_(run.coding),
        swap_(needs_swap(run.big_endian)),
        stream_(run.path, run.start_offset, run.coding) {
    stream_.skip(run.skip_bytes);
  }

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const std::int64_t z = take_plane_index();
    stream_.read(plane);
    if (swap_) {
      swap_values(plane, static_cast<std::size_t>(bytes_per_voxel(description().type)));
    }
    const bool is_last = z + 1 == description().size.z;
    if (!is_last || coding_ == StreamCoding::plain) return;
    if (const std::uint64_t left = stream_.finish(); left > 0) {
      warn(std::to_string(left) + " bytes behind the voxels were left out: " +
           escaped(stream_.path()));
    }
  }

 private:
  StreamCoding coding_;
  bool swap_;
  VoxelStream stream_;
};

/// Proves that a plain file holds all voxels.
void check_plain_length(SourceFacts& facts, const VoxelRun& run, std::uint64_t voxel_bytes) {
  const SourceFile file(run.path);
  const std::uint64_t start = checked_add(run.start_offset, run.skip_bytes, "voxel offset");
  const std::uint64_t needed = checked_add(start, voxel_bytes, "file length");
  if (file.size() < needed) {
    throw Error(ErrorKind::source_rejected,
                "the file is too short: " + std::to_string(needed) + " bytes needed for " +
                    size_text(facts.description.size) + " voxels of " +
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

std::unique_ptr<PlaneSource> make_streamed_source(SourceFacts facts, const VoxelRun& run) {
  const std::uint64_t voxel_bytes =
      checked_mul(plane_bytes(facts.description),
                  static_cast<std::uint64_t>(facts.description.size.z), "volume");
  if (run.coding == StreamCoding::plain) {
    check_plain_length(facts, run, voxel_bytes);
  } else if (run.start_offset == 0 && is_gzip_file(run.path)) {
    check_gzip_length(run.path, checked_add(run.skip_bytes, voxel_bytes, "stream length"));
  }
  return std::make_unique<StreamedSource>(std::move(facts), run);
}

}  // namespace octavo
