// Planes in, one sealed file out.
//
// Planes fill a group of brick layers; a model is trained on bricks spread over the group; its
// bricks are encoded, decoded again and compared by all workers while the next group is read and
// trained on, so that its bricks follow without a pause.
// Memory is that of two groups (a group is the fewest layers that hold 32 MiB), never that of the
// volume. The file does not depend on the number of threads.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "octavo/builder/exact_coding.h"
#include "octavo/builder/float_planes.h"
#include "octavo/codec/brick_codec.h"
#include "octavo/core/progress.h"
#include "octavo/file/storage/storage.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

/// What becomes of an interrupted build of the same file.
enum class Interrupted {
  discard,  ///< it is removed
  reject,   ///< Error{io} when some of it is whole, or another program still builds it with a
            ///< journal, before anything is read
  resume    ///< it is continued; and this build, when it fails, is kept to be continued
};

struct BuildOptions {
  VolumeKind kind = VolumeKind::grey;
  Preset preset = Preset::small;
  std::optional<Access> access = {};  ///< as CodecSettings::access
  /// No voxel ends up further from its source, in real units (|slope| * stored units). 0: lossless.
  /// Integer volumes round it down to whole stored units.
  double max_error = 0;
  /// The finest level whose details are kept, below the number of levels and 6: finer ones are
  /// interpolated, and their error is measured. 0: all are. Grey integers alone, without a max
  /// error and an access.
  int keep_details = 0;
  FloatRepair repair = {};  ///< of NaN and infinities in float32 volumes
  bool has_thumbnail = false;  ///< as WriterOptions::has_thumbnail
  bool overwrite = false;
  Interrupted interrupted = Interrupted::reject;
  /// Whether a journal is kept, for Interrupted::resume after the program was killed. Without one
  /// the next build of the file removes what a killed one left.
  bool is_resumable = true;
  int threads = 0;  ///< 0: all cores
  /// 0: no limit. Where groups of planes do not fit it, they are built in bands of bricks, for each
  /// of which a source that can seek is read again. Error{limit_exceeded} before
  /// work starts where that does not do.
  std::uint64_t max_memory_bytes = 0;
  std::uint64_t band_bytes = 0;  ///< of voxels in a band, whatever fits; 0: by the limit
  std::string progress_name = "build";  ///< of the work, for Progress::begin
  ClippedListener on_clipped = {};
};

struct BuildResult {
  std::uint64_t file_bytes = 0;
  std::uint64_t raw_bytes = 0;
  double read_seconds = 0;  ///< time the source took
  double total_seconds = 0;
  int threads = 0;
  bool is_in_bands = false;  ///< memory did not hold whole groups
  double max_error = 0;      ///< the bound that the file promises, voxel units
  std::optional<DetailErrors> detail_errors;  ///< where details were left out; real units
  std::int64_t resumed_planes = 0;  ///< that an interrupted build had encoded
  std::optional<SampleCoding> coding;  ///< of a float32 volume
  ClippedVoxels clipped;               ///< floats that only level 0 holds
};

/// Builds `path` from `source`.
/// A resumable build of more than one group keeps a journal beside the growing file: should the
/// program be killed, a build with Interrupted::resume continues it. The source is read again from
/// its start, and every group that was encoded before must have the voxels it had then. The bytes
/// of the file are those of a build without a break.
/// Throws what the source and the storage throw, Error{cancelled}, Error{internal} when a brick
/// does not decode to its voxels, Error{source_rejected} where float32 voxels do not allow what was
/// asked for, Error{invalid_argument} for labels with a max error or of type float32, or where an
/// interrupted build is of something else (Error{source_rejected} when its voxels are others); in
/// every case nothing but a complete file stands under `path`.
/// Memory  2 groups (float32: 3, with a max error 5) + 24 MiB per thread + 192 MiB (training,
///         buffers) + what the source holds; with bands 2 of these, a plane (float32: 2) and 192
///         bytes per brick, and of a layer once more, in place of the groups
/// Source  thesis 2.4 (Fig. 2.3), 2.6
BuildResult build_file(PlaneSource& source, Storage& storage, const std::string& path,
                       const BuildOptions& options, Progress& progress);

}  // namespace octavo
