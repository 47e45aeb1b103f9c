// A build in parts: each part encodes groups of its own, and a join makes the file of them.
//
//   plan_build --> plan --+--> build_part 0 --> part file --+
//                         +--> build_part 1 --> part file --+--> join_parts --> .8vo
//                         +--> ..                           |
//                         +---------------------------------+
//
// The file is that of build_file, byte for byte, however its groups and their bricks are parted,
// wherever and in whatever order parts are made.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "octavo/builder/exact_coding.h"
#include "octavo/dist/build_plan.h"
#include "octavo/dist/part_file.h"

namespace octavo {

/// How much of a machine one part or a join may take.
struct PartWork {
  int threads = 0;                     ///< 0: all cores
  std::uint64_t max_memory_bytes = 0;  ///< 0: no limit
  ClippedListener on_clipped = {};     ///< told of floats of a part that only level 0 holds
  int threads_of_all = 0;              ///< of parts that are made side by side in this process
  std::uint64_t band_bytes = 0;        ///< as BuildOptions
};

/// Encodes groups first .. end of the plan into a part file at `path`, which replaces what has that
/// name. Of the source only their planes are read, and of its files only theirs are looked at.
/// Throws  Error{source_rejected} where the source is not the one that was planned, by its
///         description, by the voxels of the first group, or by a file that was changed before the
///         part was done; Error{invalid_argument} for groups that the plan does not have, and as
///         require_codec; as build_file
/// Memory  as build_file: groups that do not fit the limit are encoded in bands
void build_part(const BuildPlan& plan, PlaneSource& source, std::int64_t first_group,
                std::int64_t end_group, Storage& storage, const std::string& path,
                const PartWork& work, Progress& progress);

/// What no part holds, as runs of groups and of bricks of a group.
std::vector<PartPlace> missing_groups(const BuildPlan& plan,
                                      const std::vector<std::shared_ptr<PartFile>>& parts);

/// Takes note of where a stream of a part belongs in the file. Those that become others
/// (PartFile::is_joined) belong nowhere.
using LeaveOut =
    std::function<void(const PartFile& part, std::size_t stream, const Section& bytes)>;

/// What is said where a disk has no room for a join; `more` ends the sentence.
Error no_room_for(const std::string& path, std::uint64_t needed_bytes, std::uint64_t free_bytes,
                  const std::string& more = "");

/// Joins parts, in any order, into the sealed file at `path`. Voxels are not read; every byte of a
/// part is proven by its checksum.
/// Throws  Error{invalid_argument} that names a part of another plan, or two of the same groups,
///         and as require_codec; Error{io} where groups are missing, and, before anything is
///         written, where the disk has no room for their bytes; Error{corrupt} for a damaged part;
///         Error{source_rejected} for bands of a group whose voxels differ; Error{limit_exceeded}
///         for more memory than the work may take; as FileWriter
/// Memory  a sample per brick, and that of the tiers above tier 0
BuildResult join_parts(const BuildPlan& plan, std::vector<std::shared_ptr<PartFile>> parts,
                       Storage& storage, const std::string& path, bool overwrite,
                       const PartWork& work, Progress& progress);

/// The same file without the streams of parts, which are copied to their places later: there it
/// holds nothing. With an empty `leave_out`, join_parts.
BuildResult lay_out_parts(const BuildPlan& plan, std::vector<std::shared_ptr<PartFile>> parts,
                          Storage& storage, const std::string& path, bool overwrite,
                          const PartWork& work, Progress& progress, const LeaveOut& leave_out);

}  // namespace octavo
