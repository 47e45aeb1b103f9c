// The source of a plan, opened for one of its parts.
#pragma once

#include <cstdint>
#include <memory>

#include "octavo/dist/build_plan.h"
#include "octavo/tasks/parts/computed_planes.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

/// The planes that the plan was made of; of a stack of files those of planes first .. end alone are
/// opened. What is noted and warned of when they are opened was so
/// when they were planned, and is not said again.
/// plan    with absolute paths, as read_plan returns it
/// first   .. end: the planes that will be read
/// parser  understands the words of a computed volume
/// Throws as open_slices, open_planes, make_isotropic and open_computed; Error{invalid_argument}
///        without a parser where one is needed
std::unique_ptr<PlaneSource> open_planned(const BuildPlan& plan, std::int64_t first,
                                          std::int64_t end, const TaskContext& context,
                                          const WorkParser& parser = {});

}  // namespace octavo
