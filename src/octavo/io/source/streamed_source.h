// A volume whose stored voxels follow one another, in one file or in pieces, x fastest: raw,
// MetaImage, NRRD, NIfTI. Other channels may stand between them, other volumes before and behind
// them.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source/described_source.h"
#include "octavo/io/source/pieced_stream.h"
#include "octavo/io/source/voxel_stream.h"

namespace octavo {

/// Where the stored voxels stand.
struct VoxelRun {
  std::string path;
  std::uint64_t start_offset = 0;  ///< in the file; where the deflated stream starts, or the voxels
  std::uint64_t skip_bytes = 0;    ///< before the voxels, counted behind decompression
  StreamCoding coding = StreamCoding::plain;
  bool big_endian = false;
  std::int64_t values_per_voxel = 1;  ///< channels that alternate
  std::int64_t value_index = 0;       ///< which of them is taken
  std::uint64_t bytes_behind = 0;     ///< of other volumes, behind the last voxel
  /// The files of voxels that stand in several: `path` is the first, and `start_offset` says
  /// nothing. None where all stand in `path`.
  std::vector<StreamPiece> pieces = {};
  std::uint64_t piece_bytes = 0;  ///< of each of these files, behind decompression

  /// All files with voxels, in their order.
  std::vector<StreamPiece> files() const;

  /// Volume `index` of `count` that follow one another, each of `volume_bytes` of one channel.
  void take_volume(std::int64_t index, std::int64_t count, std::uint64_t volume_bytes);
};

/// Delivers the planes of `run` one after the other; memory is that of a read buffer, and one
/// file is open at a time. A plain file is read from any plane on, a deflated one from its start,
/// and planes that are passed inflated as well. Where numbers are wide, the first planes are read
/// here as well, to choose what voxels they become.
/// A plain file that is too short is rejected here; a deflated stream is proven to its trailer when
/// the last plane is read. Bytes behind the voxels bring a warning.
/// The files are facts.path, which has the header, and those of the run.
/// Requires settled facts. Throws Error{source_rejected} with both lengths, Error{io}.
std::unique_ptr<PlaneSource> make_streamed_source(SourceFacts facts, const VoxelRun& run);

}  // namespace octavo
