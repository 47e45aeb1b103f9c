#include "octavo/tasks/parts/part_numbers.h"

#include <algorithm>
#include <charconv>
#include <string_view>

#include "octavo/core/error.h"
#include "octavo/core/text.h"

namespace octavo {

namespace {

/// A number of 0 or more that fills `text`.
std::optional<std::int64_t> count_in(std::string_view text) {
  std::int64_t value = 0;
  const auto* const end = text.data() + text.size();
  const auto [at, failure] = std::from_chars(text.data(), end, value);
  if (failure != std::errc{} || at != end || value < 0) return std::nullopt;
  return value;
}

std::string parts_there_are(std::int64_t count) {
  return count == 1 ? "the plan has one part, number 0"
                    : "the plan has parts 0 to " + std::to_string(count - 1);
}

/// A variable that numbers the tasks of an array.
struct ArrayVariable {
  const char* name;
  std::int64_t first;
  const char* minimum = nullptr;  ///< of the first task of the array; null where there is none
  const char* maximum = nullptr;
  const char* step = nullptr;
  const char* tasks = nullptr;  ///< of how many there are
};

constexpr ArrayVariable kArrays[] = {
    {"SLURM_ARRAY_TASK_ID", 0, "SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX",
     "SLURM_ARRAY_TASK_STEP", "SLURM_ARRAY_TASK_COUNT"},
    {"PBS_ARRAY_INDEX", 0},
    {"PBS_ARRAYID", 0},
    {"LSB_JOBINDEX", 1},
    {"SGE_TASK_ID", 1, "SGE_TASK_FIRST", "SGE_TASK_LAST", "SGE_TASK_STEPSIZE"},
    {"AWS_BATCH_JOB_ARRAY_INDEX", 0},
    {"JOB_COMPLETION_INDEX", 0},
};

/// A variable that numbers ranks, and those that say how many there are.
struct RankVariable {
  const char* name;
  std::vector<const char*> sizes;
};

const RankVariable kRanks[] = {
    {"OMPI_COMM_WORLD_RANK", {"OMPI_COMM_WORLD_SIZE"}},
    {"PMIX_RANK", {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "SLURM_STEP_NUM_TASKS", "SLURM_NTASKS"}},
    {"PMI_RANK", {"PMI_SIZE", "SLURM_STEP_NUM_TASKS", "SLURM_NTASKS"}},
    {"SLURM_PROCID", {"SLURM_STEP_NUM_TASKS"}},
};

/// What a batch script of Slurm has as well that runs before any srun.
bool is_no_rank(const RankVariable& rank, const Variables& variables) {
  return std::string_view(rank.name) == "SLURM_PROCID" &&
         variables("SLURM_STEP_NUM_TASKS") == nullptr;
}

/// What LSF and Grid Engine say where a job is no array.
bool is_no_array(const ArrayVariable& array, std::string_view value) {
  return value == "undefined" || (array.first == 1 && value == "0");
}

std::int64_t variable_number(const char* name, std::string_view value) {
  if (const auto number = count_in(value)) return *number;
  throw Error(ErrorKind::invalid_argument,
              std::string(name) + " is '" + escaped(value) + "', no number of a task");
}

/// The value of a variable that may have no name; nothing where it is not set, or empty.
const char* value_of(const char* name, const Variables& variables) {
  const char* const value = name == nullptr ? nullptr : variables(name);
  return value == nullptr || *value == '\0' ? nullptr : value;
}

std::optional<std::int64_t> count_of(const char* name, const Variables& variables) {
  const char* const value = value_of(name, variables);
  return value == nullptr ? std::nullopt : count_in(value);
}

/// The tasks of an array that are so far apart, the first of them first.
struct ArrayTasks {
  std::int64_t first;
  std::int64_t step;
  std::int64_t count;
};

/// Nothing where the array does not tell, and of a list with gaps.
std::optional<ArrayTasks> tasks_of(const ArrayVariable& array, const Variables& variables) {
  const auto lowest = count_of(array.minimum, variables);
  const auto highest = count_of(array.maximum, variables);
  if (!lowest || !highest || *highest < *lowest) return std::nullopt;
  const std::int64_t step =
      std::max<std::int64_t>(count_of(array.step, variables).value_or(1), 1);
  const std::int64_t count = (*highest - *lowest) / step + 1;
  if (count_of(array.tasks, variables).value_or(count) != count) return std::nullopt;
  return ArrayTasks{*lowest, step, count};
}

ScheduledParts array_parts(const ArrayVariable& array, std::string_view value,
                           const Variables& variables, std::int64_t count) {
  const std::int64_t number = variable_number(array.name, value);
  // Of as many tasks as there are parts, or more, the first one makes the first part.
  const std::optional<ArrayTasks> tasks = tasks_of(array, variables);
  const bool is_whole = tasks && tasks->count >= count;
  const std::int64_t task =
      is_whole ? (number - tasks->first) / tasks->step : number - array.first;
  ScheduledParts scheduled{array.name, number, 0, {}};
  if (task >= 0 && task < count) scheduled.parts = {task};
  // Where nothing says how many tasks there are, those behind the last part are too many.
  const bool is_surplus = array.minimum == nullptr && task >= count;
  if (!scheduled.parts.empty() || is_whole || is_surplus) return scheduled;
  throw Error(ErrorKind::invalid_argument,
              std::string(array.name) + " is " + std::to_string(number) + ", and " +
                  parts_there_are(count) +
                  (array.first == 0 ? ": the tasks of the array count from 0"
                                    : ": the tasks of the array count from 1"));
}

ScheduledParts rank_parts(const RankVariable& rank, std::string_view value,
                          const Variables& variables, std::int64_t count) {
  ScheduledParts scheduled{rank.name, variable_number(rank.name, value), 0, {}};
  for (const char* const name : rank.sizes) {
    const char* const size = value_of(name, variables);
    if (size == nullptr) continue;
    scheduled.stride = variable_number(name, size);
    if (scheduled.value < scheduled.stride) break;
    throw Error(ErrorKind::invalid_argument,
                std::string(rank.name) + " is " + std::to_string(scheduled.value) + ", but " +
                    name + " says " + std::to_string(scheduled.stride) + ": ranks count from 0");
  }
  if (scheduled.stride == 0) {
    throw Error(ErrorKind::invalid_argument,
                std::string(rank.name) + " is " + std::to_string(scheduled.value) +
                    ", but nothing says of how many ranks");
  }
  for (std::int64_t part = scheduled.value; part < count; part += scheduled.stride) {
    scheduled.parts.push_back(part);
  }
  return scheduled;
}

}  // namespace

std::string part_list_text(const std::vector<std::int64_t>& parts) {
  std::string text;
  for (std::size_t begin = 0; begin < parts.size();) {
    std::size_t end = begin + 1;
    while (end < parts.size() && parts[end] == parts[end - 1] + 1) ++end;
    if (!text.empty()) text += ",";
    text += std::to_string(parts[begin]);
    if (end - begin > 1) text += "-" + std::to_string(parts[end - 1]);
    begin = end;
  }
  return text;
}

std::vector<std::int64_t> parse_part_list(const std::string& text, std::int64_t count) {
  std::vector<std::int64_t> parts;
  std::string_view rest = text;
  for (bool is_last = false; !is_last;) {
    const std::size_t comma = rest.find(',');
    is_last = comma == std::string_view::npos;
    const std::string_view run = rest.substr(0, comma);
    if (!is_last) rest.remove_prefix(comma + 1);
    const std::size_t dash = run.find('-');
    const auto first = count_in(run.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : count_in(run.substr(dash + 1));
    if (!first || !last || *first > *last) {
      throw Error(ErrorKind::invalid_argument,
                  "'" + escaped(text) + "' is no list of parts such as 3,17-19");
    }
    if (*last >= count) {
      throw Error(ErrorKind::invalid_argument,
                  "there is no part " + std::to_string(*last) + ": " + parts_there_are(count));
    }
    for (std::int64_t part = *first; part <= *last; ++part) parts.push_back(part);
  }
  std::ranges::sort(parts);
  const auto doubles = std::ranges::unique(parts);
  parts.erase(doubles.begin(), doubles.end());
  return parts;
}

std::string scheduled_text(const ScheduledParts& scheduled, std::int64_t count) {
  std::string text = scheduled.variable + " is " + std::to_string(scheduled.value);
  if (scheduled.stride > 0) text += " of " + counted_text(scheduled.stride, "rank");
  const std::vector<std::int64_t>& parts = scheduled.parts;
  if (parts.empty()) return text + ": there are fewer parts, " + std::to_string(count);
  return text + (parts.size() == 1 ? ": part " : ": parts ") + part_list_text(parts) + " of " +
         std::to_string(count);
}

std::optional<ScheduledParts> scheduled_parts(const Variables& variables, std::int64_t count) {
  for (const ArrayVariable& array : kArrays) {
    const char* const value = value_of(array.name, variables);
    if (value == nullptr || is_no_array(array, value)) continue;
    return array_parts(array, value, variables, count);
  }
  for (const RankVariable& rank : kRanks) {
    const char* const value = value_of(rank.name, variables);
    if (value == nullptr || is_no_rank(rank, variables)) continue;
    return rank_parts(rank, value, variables, count);
  }
  return std::nullopt;
}

}  // namespace octavo
