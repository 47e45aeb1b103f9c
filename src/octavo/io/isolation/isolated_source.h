// A source read by another process, so that damage in a file cannot reach this one.
//
// DICOM, TIFF, PNG and OME-Zarr files pass through code that is not ours (GDCM and its codecs,
// libtiff, libpng, blosc, zstd), which may crash, hang or ask for all memory where one is damaged.
// Raw voxels, NIfTI, NRRD, MetaImage, VTK and GIPL are read by this library alone (and zlib, whose
// output is bounded), in proven steps: they need no process of their own. needs_isolation tells
// them apart.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/io/source_options.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

struct IsolationOptions {
  /// A program and its arguments that calls run_import_worker at once; `octavo import-worker` does.
  std::vector<std::string> command;
  int threads = 1;  ///< that decode planes ahead, where planes are files or pages
  /// How long to wait for a plane, or for the next read of a source that is being opened.
  std::chrono::milliseconds plane_limit = std::chrono::seconds(60);
  /// Memory the worker may take beyond what its program needs; 0: that of the machine or
  /// SourceOptions::max_memory_bytes to open the source, then what its planes call for.
  std::uint64_t memory_bytes = 0;
  /// The planes that will be asked for, where that is known before the source is opened: others are
  /// not read. A seek beyond them opens the source anew.
  std::int64_t first_plane = 0;
  std::int64_t end_plane = -1;  ///< -1: that of the volume
  std::function<bool()> is_cancelled;  ///< asked several times a second while waiting; may be empty
  /// Gets, at the end, what the worker wrote to standard output and standard error; may be empty.
  std::function<void(const std::string&)> on_output;
};

/// As open_source, in a process of its own; planes arrive through a pipe, each with a checksum,
/// read ahead by options.threads.
/// Throws  what open_source and its planes throw; Error{source_rejected} naming the file when the
///         process crashes, gives nothing in time, asks for too much memory or sends what fails its
///         checksum; Error{io} when no process can be started; Error{cancelled}
/// Memory  here that of a pipe; in the worker that of the planes held ahead
std::unique_ptr<PlaneSource> open_isolated_source(const std::vector<std::string>& paths,
                                                  const SourceOptions& source_options,
                                                  const IsolationOptions& options);

}  // namespace octavo
