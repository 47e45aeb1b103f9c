// Writes one .8vo file: append, then seal.
//
// The file grows under a temporary name beside the final one. The finest pieces are appended as
// they come; coarser ones wait in a scratch file, or in a journal, and follow at the end, level by
// level. The header says "sealed" only after everything else is on disk; then the file takes its
// final name. That name never holds anything but a complete file.
//
// A writer that is destroyed before finish() removes what it wrote. What a killed process left
// behind, the next writer of the same name removes, groups that are whole only when asked to.
// Writers that resume do neither: they keep such groups, and take over those that an earlier writer
// left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/codec/brick_codec.h"
#include "octavo/core/levels.h"
#include "octavo/core/volume.h"
#include "octavo/file/directory.h"
#include "octavo/file/storage/storage.h"
#include "octavo/file/write/brick_sink.h"
#include "octavo/file/write/encoded_run.h"
#include "octavo/file/write/journal.h"

namespace octavo {

/// Where a stream of a run belongs in a file.
struct PlacedStream {
  std::size_t run = 0;     ///< of WriterOptions::runs
  std::size_t stream = 0;  ///< of the run
  Section bytes;           ///< of the file; the run's stored_bytes of them are left out
};

struct WriterOptions {
  bool overwrite = false;  ///< replace an existing file at finish(); otherwise Error{io} at once
  /// No voxel of tier 0 lies further from its source, in voxel units; whole for integer types.
  double max_error = 0;
  /// The finest level that has details, as FileHeader::detail_level.
  int detail_level = 0;
  /// Keeps a journal beside the growing file, so that a later writer can continue it.
  bool has_journal = false;
  /// Continues what is left of an interrupted build of the same volume, if there is any; makes
  /// every group durable, and keeps the whole ones when it fails. Needs a journal. Never discards
  /// what has a whole group, and does not begin beside a build that another program works on.
  bool is_resuming = false;
  /// Gives up what interrupted builds of the file have encoded; otherwise Error{io} where some of
  /// it is whole.
  bool discards_interrupted = false;
  /// Puts a thumbnail (thumbnail.h) before all other parts.
  bool has_thumbnail = false;
  /// The first layers of tier 0 where others have encoded them: their bricks do not come again. A
  /// file without a journal.
  std::vector<std::shared_ptr<const EncodedRun>> runs = {};
  /// Takes note of where streams of runs belong; then they are not copied, and their places hold
  /// nothing when the file is sealed. Empty: they are copied.
  std::function<void(const PlacedStream&)> leave_out = {};
  /// Asked until the file takes its name: true ends finish() with Error{cancelled}.
  std::function<bool()> is_cancelled = {};
  /// How the bricks are made, lines "NAME: VALUE": writers of other settings do not continue.
  std::string settings = {};
};

/// How far the voxels of bricks lie from their source.
struct WrittenErrors {
  std::uint64_t max_steps = 0;  ///< in steps of the header
  double squared = 0;           ///< the sum of EncodedBrick::squared_error
  ValueRange range;             ///< of the bricks
};

/// Where a journal is kept, a later writer can continue behind every group that ended.
class FileWriter : public BrickSink {
 public:
  /// content_hash  of the first voxels, so that two scans alike in everything else get different
  ///               build ids
  /// description   that of a float32 volume holds its coding; range and parent of bricks are codes
  /// Throws        Error{io} when the target exists (without overwrite), is a folder, or cannot be
  ///               written, and where it shall resume what another program works on; then also
  ///               Error{invalid_argument} or, for other voxels, Error{source_rejected} when the
  ///               interrupted builds are of something else
  static std::unique_ptr<FileWriter> create(Storage& storage, const std::string& path,
                                            const VolumeDescription& description,
                                            const Levels& levels, std::uint32_t content_hash,
                                            const WriterOptions& options);
  /// The error of the bricks of tier 0 so far, those that were taken over included.
  virtual WrittenErrors written_errors() const = 0;

  /// Other metadata than those that the file was begun with; its build id stays.
  /// Throws Error{limit_exceeded}
  virtual void set_metadata(const Metadata& metadata) = 0;

  /// Keeps a part for the end of the file; parts stand in the order in which they come.
  virtual void add_part(Part part) = 0;

  /// The groups that were taken over; the bricks of the next layer come first.
  virtual const std::vector<JournalGroup>& resumed() const = 0;

  /// The bytes of the first model of a resumed file. Throws Error{io}.
  virtual Bytes first_model() const = 0;

  /// Brick layers of tier 0 that are kept for a later writer when this one ends now.
  virtual std::int64_t kept_layers() const = 0;

  /// Writes coarse levels, metadata, index and trailer, seals, syncs and renames.
  /// Throws Error{internal} when bricks are missing.
  virtual void finish() = 0;

  virtual std::uint64_t bytes_written() const = 0;
};

/// Proves that `path` can become an .8vo file: a writable name that is free, or a file that may be
/// replaced. For asking before long work; FileWriter::create asks again.
/// Returns  whether a file stands there
/// Throws   Error{io}
bool check_target(Storage& storage, const std::string& path, bool overwrite);

}  // namespace octavo
