#include "octavo/io/source/streamed_source.h"

#include <algorithm>
#include <functional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "octavo/core/checked.h"
#include "octavo/core/text.h"
#include "octavo/io/source/alternating_values.h"
#include "octavo/io/source/byte_order.h"
#include "octavo/io/source/claimed_bytes.h"
#include "octavo/io/source/source_file.h"

namespace octavo {

namespace {

constexpr std::size_t kChunkBytes = std::size_t{1} << 16;

/// Tells what stands behind voxels.
std::string left_out_warning(const BytesBehind& behind) {
  const std::int64_t others = static_cast<std::int64_t>(behind.files) - 1;
  return counted_text(static_cast<std::int64_t>(behind.count), "byte") +
         (behind.count == 1 ? " behind the voxels was left out: "
                            : " behind the voxels were left out: ") +
         escaped(behind.path) +
         (others > 0 ? " and " + counted_text(others, "other file") : std::string());
}

/// The stored numbers of a run, of one channel, in native byte order.
class StoredNumbers {
 public:
  StoredNumbers(const VoxelRun& run, std::size_t value_bytes,
                const std::function<bool()>& is_cancelled)
      : run_(run),
        value_bytes_(value_bytes),
        stream_(run.files(), run.piece_bytes, run.coding, is_cancelled) {
    stream_.skip(run.skip_bytes);
  }

  PiecedStream& stream() { return stream_; }

  /// How many numbers stand in one file from the next one on; 1 where files part it.
  std::size_t numbers_in_file() const {
    const std::uint64_t step = value_bytes_ * static_cast<std::uint64_t>(run_.values_per_voxel);
    return static_cast<std::size_t>(std::max<std::uint64_t>(stream_.bytes_in_file() / step, 1));
  }

  /// Fills `numbers` with the next ones.
  void read(std::span<std::byte> numbers) {
    if (run_.values_per_voxel == 1) {
      stream_.read(numbers);
    } else {
      read_one_of_several(numbers);
    }
    if (needs_swap(run_.big_endian)) swap_values(numbers, value_bytes_);
  }

 private:
  void read_one_of_several(std::span<std::byte> numbers) {
    const std::size_t voxel_bytes = value_bytes_ * static_cast<std::size_t>(run_.values_per_voxel);
    const Alternation one = {value_bytes_, run_.values_per_voxel, run_.value_index};
    const std::size_t chunk_voxels = std::max<std::size_t>(kChunkBytes / voxel_bytes, 1);
    std::vector<std::byte> chunk(chunk_voxels * voxel_bytes);
    for (std::size_t at = 0; at < numbers.size();) {
      const std::size_t count = std::min(chunk_voxels, (numbers.size() - at) / value_bytes_);
      stream_.read(std::span(chunk).first(count * voxel_bytes));
      take_alternating(one, chunk, numbers.subspan(at, count * value_bytes_));
      at += count * value_bytes_;
    }
  }

  VoxelRun run_;
  std::size_t value_bytes_;
  PiecedStream stream_;
};

class StreamedSource final : public DescribedSource {
 public:
  StreamedSource(SourceFacts facts, const VoxelRun& run)
      : DescribedSource(std::move(facts)),
        run_(run),
        value_bytes_(narrowing() ? bytes_per_value(narrowing()->from)
                                 : bytes_per_value(description().type)),
        numbers_(run, value_bytes_, is_cancelled()) {}

  void read_plane(std::span<std::byte> plane) override {
    require_plane(plane);
    const std::int64_t z = take_plane_index();
    at_ = description().size.z;  // should it fail: nobody knows where
    if (narrowing()) {
      read_narrowed(z, plane);
    } else {
      numbers_.read(plane);
    }
    at_ = z + 1;
    const bool is_last = at_ == description().size.z;
    if (is_last && run_.coding != StreamCoding::plain) prove_end();
  }

  bool can_seek() const override { return run_.coding == StreamCoding::plain; }

  void seek(std::int64_t first, std::int64_t end) override {
    DescribedSource::seek(first, end);
    if (first == end) return;
    if (first < at_) {
      numbers_ = StoredNumbers(run_, value_bytes_, is_cancelled());
      at_ = 0;
    }
    const Size3& size = description().size;
    const std::uint64_t plane_bytes = static_cast<std::uint64_t>(size.x * size.y) * value_bytes_ *
                                      static_cast<std::uint64_t>(run_.values_per_voxel);
    numbers_.stream().skip(static_cast<std::uint64_t>(first - at_) * plane_bytes);
    at_ = first;
  }

 private:
  void read_narrowed(std::int64_t z, std::span<std::byte> plane) {
    const std::size_t wide_bytes = bytes_per_value(narrowing()->from);
    const std::size_t voxel_bytes = bytes_per_value(narrowing()->to);
    std::vector<std::byte> chunk(std::min(kChunkBytes, plane.size() / voxel_bytes * wide_bytes));
    for (std::size_t at = 0; at < plane.size();) {
      const std::size_t count =
          std::min({chunk.size() / wide_bytes, (plane.size() - at) / voxel_bytes,
                    numbers_.numbers_in_file()});
      const std::span<std::byte> wide = std::span(chunk).first(count * wide_bytes);
      numbers_.read(wide);
      narrow(*narrowing(), wide, plane.subspan(at, count * voxel_bytes),
             {numbers_.stream().path(), description().size.x, z,
              static_cast<std::int64_t>(at / voxel_bytes)});
      at += count * voxel_bytes;
    }
  }

  void prove_end() {
    PiecedStream& stream = numbers_.stream();
    stream.skip(run_.bytes_behind);
    if (const BytesBehind left = stream.finish(); left.count > 0) warn(left_out_warning(left));
  }

  VoxelRun run_;
  std::size_t value_bytes_;
  StoredNumbers numbers_;
  std::int64_t at_ = 0;  ///< the plane that stands next in the stream
};

std::string_view stored_name(const SourceFacts& facts) {
  return stored_type_name(facts.wide ? StoredType(*facts.wide)
                                     : StoredType(facts.description.type));
}

/// What a file holds, for messages: "4 x 3 x 2 voxels of int16".
std::string content_text(const SourceFacts& facts, const VoxelRun& run) {
  const std::string part =
      run.pieces.empty() ? "" : "one of " + std::to_string(run.pieces.size()) + " parts of ";
  const std::string channels =
      run.values_per_voxel == 1 ? "" : std::to_string(run.values_per_voxel) + " channels of ";
  return part + size_text(facts.description.size) + " voxels of " + channels +
         std::string(stored_name(facts));
}

/// What each file of a run holds, with what stands before its voxels.
std::uint64_t bytes_of_each_file(const VoxelRun& run, std::uint64_t voxel_bytes) {
  return run.pieces.empty() ? checked_add(run.skip_bytes, voxel_bytes, "voxel offset")
                            : run.piece_bytes;
}

/// Proves that a plain file holds so many bytes of voxels; returns how many stand behind them.
std::uint64_t check_plain_length(const SourceFacts& facts, const VoxelRun& run,
                                 const StreamPiece& piece, std::uint64_t voxel_bytes) {
  const SourceFile file(piece.path);
  const std::uint64_t start =
      checked_add(piece.start.offset, piece.start.skip_bytes, "voxel offset");
  const std::uint64_t needed = checked_add(start, voxel_bytes, "file length");
  if (file.size() >= needed) return file.size() - needed;
  throw Error(ErrorKind::source_rejected,
              "the file is too short: " + std::to_string(needed) + " bytes needed for " +
                  content_text(facts, run) + ", " + std::to_string(file.size()) +
                  " found; it is cut or its header is wrong",
              piece.path, file.size());
}

/// The same for all files of a run, with a warning of what stands behind voxels.
void check_plain_lengths(SourceFacts& facts, const VoxelRun& run, std::uint64_t voxel_bytes) {
  const std::uint64_t bytes = bytes_of_each_file(run, voxel_bytes);
  BytesBehind behind;
  for (const StreamPiece& piece : run.files()) {
    behind.add(piece.path, check_plain_length(facts, run, piece, bytes));
  }
  if (behind.count > 0) facts.warnings.push_back(left_out_warning(behind));
}

/// Proves that deflated files can hold their voxels.
void check_deflated_lengths(const SourceFacts& facts, const VoxelRun& run,
                            std::uint64_t voxel_bytes) {
  const std::uint64_t bytes = bytes_of_each_file(run, voxel_bytes);
  std::set<std::string> proven;  // one may be named any number of times
  for (const StreamPiece& piece : run.files()) {
    if (!proven.insert(piece.path).second) continue;
    const std::uint64_t stream_bytes = checked_add(piece.start.skip_bytes, bytes, "stream length");
    require_holdable(piece.path, SourceFile(piece.path).size(), stream_bytes, kDeflateRatio);
    if (piece.start.offset == 0 && is_gzip_file(piece.path)) {
      check_gzip_length(piece.path, stream_bytes, facts.is_cancelled);
    }
  }
}

/// The header and what has voxels.
std::vector<std::string> paths_of(const SourceFacts& facts, const VoxelRun& run) {
  std::vector<std::string> paths = {facts.path};
  for (const StreamPiece& piece : run.files()) paths.push_back(piece.path);
  return paths;
}

}  // namespace

void VoxelRun::take_volume(std::int64_t index, std::int64_t count, std::uint64_t volume_bytes) {
  const std::uint64_t one =
      checked_mul(volume_bytes, static_cast<std::uint64_t>(values_per_voxel), "volume");
  const std::uint64_t before = checked_mul(one, static_cast<std::uint64_t>(index), "volumes");
  skip_bytes = checked_add(skip_bytes, before, "voxel offset");
  bytes_behind = checked_mul(one, static_cast<std::uint64_t>(count - 1 - index), "volumes");
}

std::vector<StreamPiece> VoxelRun::files() const {
  if (pieces.empty()) return {{path, {start_offset, 0}}};
  return pieces;
}

std::unique_ptr<PlaneSource> make_streamed_source(SourceFacts facts, const VoxelRun& run) {
  const std::uint64_t volume_bytes = checked_mul(
      checked_mul(stored_plane_bytes(facts),
                  static_cast<std::uint64_t>(facts.description.size.z), "volume"),
      static_cast<std::uint64_t>(run.values_per_voxel), "volume");
  const std::uint64_t voxel_bytes = checked_add(volume_bytes, run.bytes_behind, "volumes");
  if (run.coding == StreamCoding::plain) check_plain_lengths(facts, run, voxel_bytes);
  else check_deflated_lengths(facts, run, voxel_bytes);
  facts.files = files_of_volume(paths_of(facts, run));
  if (facts.wide) {
    StoredNumbers first_planes(run, bytes_per_value(*facts.wide), facts.is_cancelled);
    settle_narrowing(facts, [&](std::int64_t, std::span<std::byte> plane) {
      first_planes.read(plane);
    });
  }
  return std::make_unique<StreamedSource>(std::move(facts), run);
}

}  // namespace octavo
