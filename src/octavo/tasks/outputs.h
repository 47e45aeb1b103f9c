// The files that tasks write: what is proven of a name before long work, and how a build is set up.
#pragma once

#include <string>
#include <vector>

#include "octavo/builder/builder.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// Where a result goes.
struct Output {
  std::string path;
  bool overwrite = false;  ///< a file of that name, or what is left of its build, is replaced
  bool has_thumbnail = false;  ///< an .8vo file gets one
};

/// Throws Error{io} where the folder that a path lies in is missing, is none, or takes no files.
void require_folder_around(const std::string& path);

/// Throws Error{io} when the name cannot be used: too long, a folder, in none or in one that takes
/// no files, taken and not to be overwritten.
void require_free(const Output& output);

/// Throws Error{invalid_argument} when a file to write is one of `inputs`, under any name.
void require_no_input(const std::string& path, const std::vector<std::string>& inputs);

/// Throws Error{invalid_argument} when two of the files to write are one; empty names are none.
void require_apart(const std::vector<std::string>& outputs);

/// require_free for an .8vo file that is computed from others. Throws Error{invalid_argument} when
/// its name does not end in .8vo, or is one of `inputs`, even with overwrite.
void require_computed(const Output& output, const std::vector<std::string>& inputs);

/// For results whose size the caller chose, before any work: throws Error{limit_exceeded} with both
/// numbers when a file cannot hold so many voxels, or when building them takes more memory than
/// the limit of `options` or, without one, this machine has.
/// source_bytes  held by what gives the planes
/// advice        what to ask for instead, the end of the message: "take a smaller grid"
void require_room_for(const VolumeDescription& volume, const BuildOptions& options,
                      std::uint64_t source_bytes, const Output& output, const char* advice);

/// Warns of floats that coarse levels of `path` do not hold.
ClippedListener clipped_listener(const std::string& path, const TaskContext& context);

/// `options` with what the context and the output say: threads, memory, overwriting, and what
/// becomes of an interrupted build (Interrupted::resume is kept).
/// work  names the progress
BuildOptions build_options_for(const TaskContext& context, const Output& output,
                               const std::string& work, BuildOptions options = {});

}  // namespace octavo
