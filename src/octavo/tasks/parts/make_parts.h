// Parts by a plan: the task of `part`.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "octavo/builder/exact_coding.h"
#include "octavo/dist/build_plan.h"
#include "octavo/tasks/parts/computed_planes.h"
#include "octavo/tasks/parts/part_numbers.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct MakePartsOptions {
  std::string plan;
  std::string parts;       ///< their numbers, "3,17-19"; empty: those that a scheduler gives
  Variables variables;     ///< of the environment, where a scheduler says which
  WorkParser parser;       ///< of plans of computed volumes
  std::string folder;      ///< that they are written to; empty: that of the plan
  std::string source_root;  ///< as read_plan
  bool overwrite = false;  ///< parts are made that are there, whatever they are of
};

struct MadePart {
  std::int64_t number = 0;
  std::string path;
  std::uint64_t file_bytes = 0;
  bool was_there = false;  ///< whole, of this plan: it was kept
};

struct MakePartsResult {
  std::int64_t part_count = 0;
  std::optional<ScheduledParts> scheduled;  ///< where no parts were asked for
  std::vector<MadePart> parts;
};

/// Makes parts one after another, each on all threads of the context. What is whole for this plan
/// is kept, what is damaged is made anew. Notes which parts a scheduler gave.
/// Throws  as read_plan, parse_part_list, scheduled_parts, open_planned and build_part;
///         Error{invalid_argument} where nothing says which of several parts and, without
///         overwrite, where a part of another plan, or what is no part, has the name
/// Memory  as build_part
MakePartsResult make_parts(const MakePartsOptions& options, const TaskContext& context);

/// One of them, for a plan that was read. threads_of_all, on_clipped: as PartWork
MadePart make_part(const BuildPlan& plan, std::int64_t part, const std::string& path,
                   int threads_of_all, const ClippedListener& on_clipped,
                   const WorkParser& parser, const TaskContext& context);

}  // namespace octavo
