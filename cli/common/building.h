// Builds a file from planes and says how it went: shared by `build` and `phantom`.
#pragma once

#include <string>

#include "common/context.h"
#include "octavo/builder/builder.h"

namespace octavo::cli {

/// `options` with what `context` says: overwriting, what became of an interrupted build, threads,
/// memory and the verb, which names the progress. Interrupted::resume is kept.
BuildOptions with_context(BuildOptions options, const Context& context);

/// For results whose size the user chose, before any work: throws Error{limit_exceeded} with both
/// numbers when a file cannot hold so many voxels, or when building them takes more memory than
/// --max-memory allows or, without it, this machine has.
/// source_bytes  held by what gives the planes
/// advice        the end of the message: "take a smaller --scale"
void require_room_for(const VolumeDescription& volume, const BuildOptions& options,
                      std::uint64_t source_bytes, const std::string& output,
                      const std::string& advice);

/// Builds `output` with progress and prints the result. Returns the exit code.
/// options  what to build; overwrite, threads and memory are those of `context`
int build_and_report(PlaneSource& source, BuildOptions options, const std::string& output,
                     const Context& context);

}  // namespace octavo::cli
