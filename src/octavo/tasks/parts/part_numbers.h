// Numbers of parts as job schedulers write them.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace octavo {

/// "3,17-19" for 3, 17, 18, 19. Requires ascending numbers.
std::string part_list_text(const std::vector<std::int64_t>& parts);

/// The numbers of such a text, ascending, each once.
/// Throws  Error{invalid_argument} for anything else, and for a number that is not below `count`
std::vector<std::int64_t> parse_part_list(const std::string& text, std::int64_t count);

/// The parts that a scheduler gives to one task.
struct ScheduledParts {
  std::string variable;              ///< that says so
  std::int64_t value = 0;            ///< of the variable
  std::int64_t stride = 0;           ///< ranks that share the work; 0: a task is one part
  std::vector<std::int64_t> parts;   ///< none where there are fewer parts than tasks
};

/// "SLURM_ARRAY_TASK_ID is 8: part 7 of 117".
std::string scheduled_text(const ScheduledParts& scheduled, std::int64_t count);

/// What an environment variable holds; null where there is none.
using Variables = std::function<const char*(const char* name)>;

/// Reads what Slurm, PBS, LSF, Grid Engine, AWS Batch and Kubernetes set in the tasks of an array,
/// else what Open MPI, PMIx and srun set in ranks: rank r of n makes parts r, r + n, ...
/// Arrays of LSF and Grid Engine begin at 1, all others at 0. Where Slurm and Grid Engine say that
/// an array has as many tasks as there are parts, or more, its first task makes the first part,
/// whatever its number; the tasks that are too many make none, those of other schedulers neither.
/// SLURM_PROCID counts in a step of srun alone: a batch script has it, too.
/// Returns  nothing where no variable is set
/// Throws   Error{invalid_argument} for a task that has no part, or is no number
std::optional<ScheduledParts> scheduled_parts(const Variables& variables, std::int64_t count);

}  // namespace octavo
