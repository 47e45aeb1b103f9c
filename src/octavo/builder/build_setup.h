// What every build begins with: threads, levels, memory, and how a lack of it is worded.
#pragma once

#include <cstdint>
#include <string>

#include "octavo/core/error.h"
#include "octavo/core/levels.h"
#include "octavo/core/metadata_facts.h"
#include "octavo/core/volume.h"

namespace octavo {

/// What a thread needs while it encodes and trains.
inline constexpr std::uint64_t kThreadBytes = std::uint64_t{24} << 20;

/// Counts the changes of what a build makes of the same voxels and options: one more whenever bytes
/// of its files become others. docs/registry.md says what each number stands for.
inline constexpr std::int64_t kEncodingRevision = 1;

/// What builds say of themselves in the metadata.
WriterNote this_writer();

/// `wanted`, or for 0 all cores.
int build_threads(int wanted);

/// The levels of a volume. Throws Error{limit_exceeded} on a bad size.
Levels levels_of(const VolumeDescription& description);

/// Throws Error{limit_exceeded} where a build needs more than a limit that is not 0.
/// threads  that it uses
/// why      the end of the message: why it cannot do with less
void check_build_memory(std::uint64_t needed_bytes, std::uint64_t limit_bytes, int threads,
                        const char* why = "");

/// Error{out_of_memory} of a build of `path`.
Error out_of_build_memory(const std::string& path);

}  // namespace octavo
