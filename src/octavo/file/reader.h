// Reads one .8vo file: what it holds, any box at any level, any brick by o-code.
//
// Opening costs two reads: the header, and the tail with the root index. Everything that comes from
// the file is proven (checksum, then ranges) before it is used. A handle serves any number of
// threads.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "octavo/core/bytes.h"
#include "octavo/core/hasher.h"
#include "octavo/core/levels.h"
#include "octavo/core/progress.h"
#include "octavo/core/volume.h"
#include "octavo/file/directory.h"
#include "octavo/file/for_each.h"
#include "octavo/file/read_plan.h"
#include "octavo/file/storage/byte_source.h"
#include "octavo/octree/label_words.h"

namespace octavo {

struct VoxelTarget;

struct ReaderOptions {
  std::uint64_t cache_bytes = std::uint64_t{256} << 20;  ///< decoded bricks kept, at most
  std::uint64_t max_metadata_bytes = std::uint64_t{16} << 20;
  /// The pages of the index are read when the file is opened where that takes no more than this;
  /// else one by one when they are needed.
  std::uint64_t max_tail_bytes = std::uint64_t{1} << 20;
  /// Where bytes have to be fetched, so many that stand before the index come along when a file is
  /// opened: those of the coarsest levels.
  std::uint64_t lead_bytes = std::uint64_t{1} << 18;
  /// Whether damaged bytes are asked for once more, where their source can bring them anew.
  bool asks_again = true;
  /// Its is_cancelled() ends every reading of voxels at the next brick, with Error{cancelled}. It
  /// outlives the reader; may be null.
  const Progress* watcher = nullptr;
};

/// One brick as the index knows it.
struct BrickEntry {
  int tier = 0;
  Index3 brick;             ///< position in the tier's brick grid
  std::uint64_t code = 0;   ///< o-code of that position
  /// Smallest and largest voxel; for float32 their codes. Bounds where lossy and of exact floats.
  ValueRange range;
  double max_error = 0;     ///< largest |voxel - source voxel| at level 0, voxel units
  bool is_uniform() const { return range.min == range.max; }
  struct StoredPiece {
    std::uint64_t offset = 0;
    std::uint64_t length = 0;
    std::uint32_t crc = 0;
  };
  std::vector<StoredPiece> pieces;  ///< finest first (pieces.h)
  std::uint32_t model = 0;
};

/// Sums over the bricks of one level.
struct LevelSummary {
  std::int64_t bricks = 0;
  std::int64_t uniform_bricks = 0;
  /// Of the pieces that begin with its segments.
  std::uint64_t bytes = 0;
  /// Its segments stand in the pieces of a finer level, with whose bytes they are counted.
  bool is_in_finer = false;
};

/// Side lengths of a full brick of the level's tier, in samples of `level`.
Size3 brick_side_at(const Levels& levels, int level);

/// Voxels of a brick of the level's tier, in samples of `level`; less than its sides at the end of
/// the volume.
Box brick_box_at(const Levels& levels, int level, const Index3& brick);

class FileReader {
 public:
  /// Throws Error{not_octavo, unsupported_version, truncated, corrupt, limit_exceeded, io}.
  static std::shared_ptr<FileReader> open(std::shared_ptr<const ByteSource> source,
                                          const ReaderOptions& options = {});
  virtual ~FileReader() = default;

  virtual const VolumeDescription& description() const = 0;
  virtual const Levels& levels() const = 0;
  virtual std::uint64_t file_bytes() const = 0;
  virtual std::uint64_t build_id() const = 0;
  /// The SHA-256 of those of the planes of level 0: equal voxels, equal digest.
  virtual Sha256Digest voxel_digest() const = 0;
  virtual const ByteSource& source() const = 0;
  /// "1.0"
  virtual std::string format_version() const = 0;
  /// Smallest and largest stored voxel; for float32 those of the codes, which
  /// description().voxel_of turns into voxels. In a lossy file, and of exact floats, these are
  /// bounds, the latter as far off as floats go where description().is_unbounded says so.
  virtual ValueRange range() const = 0;
  /// The promise: no voxel of level 0 differs from its source by more, voxel units; 0 is lossless.
  /// Where details were left out, what was measured.
  virtual double max_error() const = 0;
  /// The finest level that has details; finer ones are interpolated from it.
  virtual int detail_level() const = 0;
  /// The largest difference that was measured when the file was built; at most max_error().
  virtual double achieved_error() const = 0;
  virtual LevelSummary level_summary(int level) const = 0;
  /// The order in which the axes of a level are halved. Throws Error{corrupt} for a damaged model.
  virtual AxisOrder axis_order() const = 0;

  /// Throws Error{invalid_argument} outside the grid.
  virtual BrickEntry brick(int tier, const Index3& position) const = 0;

  /// Decodes one brick at one of its levels: dense [z][y][x] of brick_shape(...).size[in-brick
  /// level], in the volume's type. Uniform bricks are filled without a read.
  virtual void read_brick(const BrickEntry& entry, int in_brick_level, void* out) const = 0;

  /// The labels of one brick at its finest level as words: those of what read_brick gives. Files
  /// give them without an array of voxels.
  /// Throws Error{invalid_argument} for grey volumes
  virtual void read_words(const BrickEntry& entry, LabelWords& words) const;

  /// Reads `box` (in samples of `level`) into `out`, dense [z][y][x] in the volume's type.
  /// Goes through the brick cache; decodes on the calling thread. Of a brick whose level 0 has
  /// parts that decode alone, only those that the box meets are read and decoded.
  /// Throws Error{invalid_argument} when the box is empty or not inside the level; Error{corrupt}
  /// naming brick, level and offset.
  virtual void read(const Box& box, int level, void* out) const = 0;

  /// The same into a part of a larger array: `row_stride` and `plane_stride` in voxels.
  virtual void read_strided(const Box& box, int level, void* out, std::int64_t row_stride,
                            std::int64_t plane_stride) const = 0;

  /// The same; those parts of a brick that decode alone are tasks of `run`, which may give them to
  /// several threads. Neither the voxels nor the error of a damaged file depend on how it does.
  /// Readers of no such parts read on the calling thread.
  virtual void read_in_tasks(const Box& box, int level, const VoxelTarget& out,
                             const ForEach& run) const;

  /// What is missing of the bytes that reading `box` needs: pages of the index, models, pieces of
  /// bricks or parts of them. Where some of these tell where others stand, the plan is not
  /// complete: once its ranges are there, the next one names the rest. Nothing is missing of files
  /// at hand.
  /// Throws Error{invalid_argument} as read(); Error{corrupt} for a damaged page or model
  virtual ReadPlan ranges_of(const Box& box, int level, const JoinLimits& limits = {}) const;

  /// Fetches what reading boxes needs beside what is kept, in few requests. False, with nothing or
  /// some of it fetched, where the source keeps less: then they are better read a few at a time. Of
  /// bytes at hand nothing is fetched.
  /// Throws as ranges_of() and ByteSource::fetch()
  virtual bool fetch(std::span<const Box> boxes, int level) const;

  /// Calls read(part) for boxes that tile `box`, one after the other, each of them fetched. The
  /// last one has the end of `box`. What a part needs stays until the next call has returned: it
  /// may still be read while the next part is fetched. Of bytes at hand `box` is one part. Readers
  /// do this for every box themselves; who reads a box in pieces does it for the whole of it first.
  /// Throws as fetch(), and what `read` throws
  virtual void for_fetched(const Box& box, int level,
                           const std::function<void(const Box& part)>& read) const;

  /// The length of the thumbnail; 0 when there is none.
  virtual std::uint64_t thumbnail_bytes() const = 0;
  /// The PNG picture of the file; empty when it has none. Throws Error{corrupt}.
  virtual Bytes thumbnail() const = 0;

  /// What stands beside the voxels, in the order of the file.
  virtual std::vector<PartEntry> parts() const { return {}; }
  /// Extensions of the header that this program does not know.
  virtual std::vector<UnknownExtension> unknown_extensions() const { return {}; }

  /// Raw bytes of a piece after its checksum was proven.
  virtual Bytes read_piece(const BrickEntry& entry, int piece) const = 0;
};

}  // namespace octavo
