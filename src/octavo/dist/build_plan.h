// What the first group of a build decides for all of them, so that each can be encoded apart.
//
// Groups depend on one another by the build id, which holds a checksum of the first group's voxels,
// by the coding of floats, by the order in which axes are halved, and by the first group's model,
// from which the others are refined. A plan holds these; with it a group depends on its own planes
// alone.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/builder/build_outline.h"
#include "octavo/builder/builder.h"
#include "octavo/builder/float_planes.h"
#include "octavo/core/bytes.h"
#include "octavo/core/progress.h"
#include "octavo/core/volume.h"
#include "octavo/dist/part_place.h"
#include "octavo/dist/source_stamp.h"
#include "octavo/file/layout.h"
#include "octavo/planes/plane_source.h"
#include "octavo/planes/slice_stack.h"

namespace octavo {

struct BuildPlan {
  /// How bricks are made. Threads, memory, overwriting and what becomes of interrupted builds are
  /// those of whoever works by the plan.
  BuildOptions options;
  VolumeDescription source;           ///< as the source described itself
  std::optional<FloatChoice> floats;  ///< of a float32 source
  std::uint32_t content_hash = 0;     ///< of the first group
  std::uint32_t codec_check = 0;      ///< codec_check() of the program that made the plan
  Bytes first_model;
  std::int64_t planes_per_group = 0;
  std::int64_t group_count = 0;
  /// What opens the source, for whoever does: names in their order, and a JSON object of options.
  /// Nothing here looks into them.
  std::vector<std::string> inputs;
  std::string recipe = "{}";
  /// The groups are dealt out to so many parts, evenly: 1 to group_count, where they have no bands.
  std::int64_t part_count = 1;
  /// So many parts share each group, 1 to the bricks of a layer; above 1 there are group_count *
  /// bands parts.
  std::int64_t bands = 1;
  std::vector<SourceStamp> files;  ///< of the source, as they were when it was planned
  /// The slices that planes are made of, where a part can open those of its planes alone: path i is
  /// that of files[i].
  std::optional<SliceStack> stack;
  /// A digest of all that bytes of the file depend on: for the voxels behind the first group the
  /// files stand.
  std::uint64_t id = 0;
};

/// Reads the first planes of `source` and trains on them.
/// files   that the source reads (PlaneSource::files): who works by the plan proves that none was
///         changed since. None for voxels that stand in no file
/// stack   slice_stack_of what `source` was made of, where its paths are those of `files`
/// check   what tells of a change; their content only where each plane tells its files: who works
///         by the plan reads those of its planes, and no others
/// Throws  as build_file and stamps_of; Error{source_rejected} for a file that changes meanwhile;
///         Error{invalid_argument} where no plane tells its files
/// Memory  the bricks that are trained on, where integers stay as they are and the source seeks;
///         else as build_file
BuildPlan plan_build(PlaneSource& source, const BuildOptions& options, Progress& progress,
                     const std::vector<std::string>& files = {},
                     const std::optional<SliceStack>& stack = std::nullopt,
                     FileCheck check = FileCheck::times);

/// Proves that a plan has the groups that this program would make.
/// Throws Error{invalid_argument}, Error{limit_exceeded}
void require_groups(const BuildPlan& plan);

/// Proves that this program makes the bytes that the plan's makes. Throws Error{invalid_argument}
void require_codec(const BuildPlan& plan);

/// What BuildPlan::id is to be. Throws as outline_build
std::uint64_t id_of(const BuildPlan& plan);

/// The files that planes first .. end are made of: all where the source does not say which.
/// source  that of the plan, which tells by PlaneSource::files
std::vector<SourceStamp> files_of(const BuildPlan& plan, const PlaneSource& source,
                                  std::int64_t first, std::int64_t end);

/// Looks for the files of the source in `folder` from now on: it takes the place of the folder that
/// holds all of them, in their paths and in those of the inputs. The id stays: the same files stand
/// elsewhere.
void move_files(BuildPlan& plan, const std::string& folder);

/// What the plan says, as a build would have found it.
/// source  read by the floats of the outline; nothing of it is read here
/// Throws  as outline_build
BuildOutline outline_of(const BuildPlan& plan, PlaneSource& source, Progress& progress);

/// The same for who reads no plane: without floats.
BuildOutline outline_of(const BuildPlan& plan);

/// The header that the file begins with.
FileHeader header_of(const BuildPlan& plan, const BuildOutline& outline);

/// The first plane of a group; for the count of groups, that of planes.
std::int64_t first_plane_of(const BuildPlan& plan, std::int64_t group);

/// The bricks of a layer of tier 0.
std::int64_t layer_bricks_of(const BuildPlan& plan);

/// What a part holds, 0 <= part < part_count.
PartPlace place_of(const BuildPlan& plan, std::int64_t part);

/// The part that has a place; nothing where none of the plan has.
std::optional<std::int64_t> part_at(const BuildPlan& plan, const PartPlace& place);

}  // namespace octavo
