// What the first group of a build decides for all of them, so that each can be encoded apart.
//
// Groups depend on one another by the build id, which holds a checksum of the first group's voxels,
// by the coding of floats, by the order in which axes are halved, and by the first group's model,
// from which the others are refined. A plan holds these; with it a group depends on its own planes
// alone.
#pragma once

#include <cstdint>
#include <optional>

#include "octavo/builder/build_outline.h"
#include "octavo/builder/builder.h"
#include "octavo/builder/float_planes.h"
#include "octavo/core/bytes.h"
#include "octavo/core/progress.h"
#include "octavo/core/volume.h"
#include "octavo/file/layout.h"
#include "octavo/planes/plane_source.h"

namespace octavo {

struct BuildPlan {
  /// How bricks are made. Threads, memory, overwriting and what becomes of interrupted builds are
  /// those of whoever works by the plan.
  BuildOptions options;
  VolumeDescription source;           ///< as the source described itself
  std::optional<FloatChoice> floats;  ///< of a float32 source
  std::uint32_t content_hash = 0;     ///< of the first group
  Bytes first_model;
  std::int64_t planes_per_group = 0;
  std::int64_t group_count = 0;
  /// A digest of all that bytes of the file depend on, but for the voxels behind the first group.
  std::uint64_t id = 0;
};

/// Reads the first planes of `source` and trains on them.
/// Throws  as build_file
BuildPlan plan_build(PlaneSource& source, const BuildOptions& options, Progress& progress);

/// What the plan says, as a build would have found it.
/// source  read by the floats of the outline; nothing of it is read here
/// Throws  as outline_build
BuildOutline outline_of(const BuildPlan& plan, PlaneSource& source, Progress& progress);

/// The header that the file begins with.
FileHeader header_of(const BuildPlan& plan, const BuildOutline& outline);

/// Planes of groups first .. end.
std::int64_t first_plane_of(const BuildPlan& plan, std::int64_t group);

}  // namespace octavo
