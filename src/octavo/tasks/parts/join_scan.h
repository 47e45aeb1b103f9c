// Parts in, one sealed file out: the task of `join`.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "octavo/dist/build_plan.h"
#include "octavo/dist/parts.h"
#include "octavo/tasks/build_planes.h"

namespace octavo {

struct JoinOptions {
  std::string plan;
  /// Files, or one folder in which parts have their names; none: the folder of the plan.
  std::vector<std::string> parts;
  Output output;
  /// Each part is removed once it is in the file, so that no more room is needed than that of the
  /// file and the largest part.
  bool consumes_parts = false;
};

/// Joins the parts of a plan. The source is not read and need not be there.
/// Throws  as read_plan, require_joined_name, require_no_part and join_parts; Error{io} that lists
///         parts which are missing; with consumes_parts also as consume_parts
/// Memory  as join_parts
BuiltVolume join_scan(const JoinOptions& options, const TaskContext& context);

/// The same join for a plan that was read, of parts at these paths, by number.
BuiltVolume join_planned(const BuildPlan& plan, const std::map<std::int64_t, std::string>& paths,
                         const Output& output, const TaskContext& context);

/// Throws Error{invalid_argument} for a name that does not end in .8vo; as require_free
void require_joined_name(const Output& output);

/// Throws Error{invalid_argument} where an output is one of the parts, by whatever name.
void require_no_part(const std::string& output, const std::map<std::int64_t, std::string>& parts);

/// How the parts of `output` are joined: clipped floats of all of them are a warning before the
/// file stands.
PartWork join_work(const Output& output, const TaskContext& context);

/// A part that is not there, or that no join takes.
struct MissingPart {
  std::int64_t number = 0;
  std::string why;  ///< of one that stands there; else empty
};

struct MissingParts {
  std::int64_t part_count = 0;
  std::vector<MissingPart> missing;  ///< by number

  /// "3,17-19".
  std::string list() const;
};

/// The parts that have to be made, again or at all, before a join. Every byte of those that are
/// there is proven; what is of another plan counts as missing, and so do parts of one group that
/// were made of other voxels than one another. What a join to the output, or else to the
/// proposed_volume, has copied counts as there, unless it was changed since. Notes what is wrong
/// with a part.
/// Throws as read_plan
MissingParts missing_parts(const JoinOptions& options, const TaskContext& context);

}  // namespace octavo
