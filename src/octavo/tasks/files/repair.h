// What an interrupted build left, or a damaged file, made whole as far as it can be.
#pragma once

#include <string>
#include <variant>

#include "octavo/builder/recover.h"
#include "octavo/file/repair/repair_bits.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/task_context.h"

namespace octavo {

struct RepairOptions {
  std::string input;  ///< what was being built, what is left of it, or a damaged .8vo file
  Output output;
};

/// A recovered build, or a file with its bits turned back.
using RepairResult = std::variant<SealResult, BitRepairResult>;

/// Throws  as seal_interrupted and repair_bits; Error{invalid_argument} for a sound file, for a
///         name that does not end in .8vo, and for the input as its own output
RepairResult repair(const RepairOptions& options, const TaskContext& context);

}  // namespace octavo
