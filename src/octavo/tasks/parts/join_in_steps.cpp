#include "octavo/tasks/parts/join_in_steps.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/dist/join_steps.h"
#include "octavo/dist/parts.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/parts/part_places.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/standing_part.h"

namespace octavo {

namespace {

/// path  of the join, whose layout says so
std::int64_t number_of(const BuildPlan& plan, const PartPlace& place, const std::string& path) {
  if (const auto number = part_at(plan, place)) return *number;
  throw Error(ErrorKind::corrupt, "the layout of the join has other parts than the plan", path);
}

std::vector<std::int64_t> uncopied_numbers(const BuildPlan& plan, const JoinLayout& layout,
                                           const std::string& path) {
  std::vector<std::int64_t> numbers;
  for (const PartPlace& place : uncopied_parts(layout, local_storage(), path)) {
    numbers.push_back(number_of(plan, place, path));
  }
  std::ranges::sort(numbers);
  return numbers;
}

/// Lays the file out unless that was done; then no part need be there.
JoinLayout laid_out(const BuildPlan& plan, const JoinOptions& options, const TaskContext& context) {
  const std::string& path = options.output.path;
  if (auto layout = find_layout(plan, local_storage(), path)) return *layout;
  const PartPlaces places = places_of(options);
  const auto found = found_parts(plan, places, options.plan);
  require_all_found(plan, found, places, options.plan);
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const auto& [part, file] : found) {
    context.stop_if_cancelled();
    parts.push_back(open_part(plan, part, file));
  }
  return lay_out_join(plan, parts, local_storage(), path, options.output.overwrite,
                      {context.threads, context.max_memory_bytes}, context.watcher());
}

JoinLayout required_layout(const BuildPlan& plan, const std::string& path) {
  if (auto layout = find_layout(plan, local_storage(), path)) return *layout;
  throw Error(ErrorKind::io, "nothing is laid out for this plan", path).with_field("join.layout");
}

std::vector<std::int64_t> numbers_to_copy(const JoinStepOptions& options, const BuildPlan& plan,
                                          const JoinLayout& layout, const TaskContext& context) {
  if (!options.numbers.empty()) return parse_part_list(options.numbers, plan.part_count);
  if (options.variables) {
    if (const auto scheduled = scheduled_parts(options.variables, plan.part_count)) {
      context.note(scheduled_text(*scheduled, plan.part_count));
      return scheduled->parts;
    }
  }
  if (!options.join.consumes_parts) {
    return uncopied_numbers(plan, layout, options.join.output.path);
  }
  // Who was killed may have left parts that are copied.
  std::vector<std::int64_t> all(static_cast<std::size_t>(plan.part_count));
  std::iota(all.begin(), all.end(), 0);
  return all;
}

void copy_numbers(const JoinStepOptions& options, const BuildPlan& plan, const JoinLayout& layout,
                  JoinStepResult& result, const TaskContext& context) {
  const std::string& path = options.join.output.path;
  const auto found = found_parts(plan, places_of(options.join), options.join.plan);
  const std::vector<std::int64_t> left = uncopied_numbers(plan, layout, path);
  for (const std::int64_t number : numbers_to_copy(options, plan, layout, context)) {
    const bool is_copied = !std::ranges::binary_search(left, number);
    const auto file = found.find(number);
    const bool is_there = file != found.end() && local_storage().exists(file->second);
    if (is_copied && !(options.join.consumes_parts && is_there)) continue;
    if (file == found.end()) {
      throw Error(ErrorKind::io, "part " + std::to_string(number) + " is not there", path)
          .with_field("parts.missing", std::to_string(number))
          .with_field("parts.plan_path", options.join.plan);
    }
    copy_part(plan, open_part(plan, number, file->second), local_storage(), path,
              options.join.consumes_parts, context.watcher());
    if (!is_copied) result.copied.push_back(number);
  }
}

/// Says which parts are missing in a file that is laid out.
void require_all_copied(const BuildPlan& plan, const JoinOptions& options) {
  const std::string& path = options.output.path;
  const auto layout = find_layout(plan, local_storage(), path);
  if (!layout) return;
  const std::vector<std::int64_t> left = uncopied_numbers(plan, *layout, path);
  if (left.empty()) return;
  throw Error(ErrorKind::io,
              std::to_string(left.size()) + " of " + counted_text(plan.part_count, "part") +
                  (left.size() == 1 ? " was" : " were") + " not copied: " + part_list_text(left),
              path);
}

}  // namespace

JoinStepResult join_step(const JoinStepOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.join.plan);
  const Output& output = options.join.output;
  JoinStepResult result;
  result.part_count = plan.part_count;
  if (options.step == JoinStep::seal) {
    require_all_copied(plan, options.join);
    result.file_bytes = seal_join(plan, local_storage(), output.path, output.overwrite);
    return result;
  }
  const bool is_layout = options.step == JoinStep::layout;
  if (!is_layout && !find_layout(plan, local_storage(), output.path) &&
      is_joined(plan, local_storage(), output.path)) {
    result.file_bytes = local_storage().open_read(output.path)->size();
    result.is_done = true;
    return result;
  }
  if (is_layout) require_joined_name(output);
  const JoinLayout layout = is_layout ? laid_out(plan, options.join, context)
                                      : required_layout(plan, output.path);
  if (!is_layout) copy_numbers(options, plan, layout, result, context);
  result.file_bytes = layout.file_bytes;
  result.uncopied = uncopied_numbers(plan, layout, output.path);
  return result;
}

JoinRuns join_runs(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  require_joined_name(options.output);
  const JoinLayout layout = laid_out(plan, options, context);
  // Whoever reads the list may stand in another folder.
  const auto absolute = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal().string();
  };
  JoinRuns result{absolute(joined_name(options.output.path)), layout.file_bytes, {}};
  const auto found = found_parts(plan, places_of(options), options.plan);
  std::map<std::uint64_t, FileRun> by_offset;
  for (const Section& own : own_bytes_of(layout)) {
    by_offset[own.offset] = {result.own_file, own.offset, own.length};
  }
  for (const CopiedRun& run : layout.runs) {
    const std::int64_t part = number_of(plan, run.part, options.output.path);
    const auto file = found.find(part);
    const std::string path = file != found.end()
                                 ? file->second
                                 : path_of_part(places_of(options).folder, options.plan, part,
                                                plan.part_count);
    by_offset[run.file_offset] = {absolute(path), run.part_offset, run.length};
  }
  for (auto& [offset, run] : by_offset) result.runs.push_back(std::move(run));
  return result;
}

}  // namespace octavo
