#include "octavo/tasks/parts/join_in_steps.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <optional>
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
  require_no_part(path, found);
  require_all_found(plan, found, places, options.plan);
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const auto& [part, file] : found) {
    context.stop_if_cancelled();
    parts.push_back(open_part(plan, part, file));
  }
  return lay_out_join(plan, parts, local_storage(), path, options.output.overwrite,
                      join_work(options.output, context), context.watcher());
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

/// Where the part of a number is; empty where it is not there.
class PartFinder {
 public:
  PartFinder(const BuildPlan& plan, const JoinOptions& options)
      : plan_(plan), options_(options), places_(places_of(options)) {
    if (places_.folder.empty()) given_ = found_parts(plan, places_, options.plan);
  }

  std::string find(std::int64_t number) const {
    if (places_.folder.empty()) {
      const auto file = given_.find(number);
      const bool is_there = file != given_.end() && local_storage().exists(file->second);
      return is_there ? file->second : std::string();
    }
    const std::string path =
        path_of_part(places_.folder, options_.plan, number, plan_.part_count);
    return local_storage().exists(path) ? path : std::string();
  }

 private:
  const BuildPlan& plan_;
  const JoinOptions& options_;
  PartPlaces places_;
  std::map<std::int64_t, std::string> given_;  ///< one by one
};

void copy_numbers(const JoinStepOptions& options, const BuildPlan& plan, const JoinLayout& layout,
                  JoinStepResult& result, const TaskContext& context) {
  const std::string& path = options.join.output.path;
  const PartFinder finder(plan, options.join);
  const PartCopier copier(plan, layout, local_storage(), path);
  for (const std::int64_t number : numbers_to_copy(options, plan, layout, context)) {
    context.stop_if_cancelled();
    const bool is_copied = copier.is_copied(place_of(plan, number));
    if (is_copied && !options.join.consumes_parts) continue;
    const std::string file = finder.find(number);
    if (is_copied && file.empty()) continue;
    if (file.empty()) {
      throw Error(ErrorKind::io, "part " + std::to_string(number) + " is not there", path)
          .with_field("parts.missing", std::to_string(number))
          .with_field("parts.plan_path", options.join.plan);
    }
    require_no_part(path, {{number, file}});
    copier.copy(open_part(plan, number, file), options.join.consumes_parts, context.watcher());
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
  context.require_voxels(plan.source.size, options.join.plan);
  const Output& output = options.join.output;
  JoinStepResult result;
  result.part_count = plan.part_count;
  if (options.step == JoinStep::seal) {
    require_all_copied(plan, options.join);
    result.file_bytes = seal_join(plan, local_storage(), output.path, output.overwrite,
                                  join_work(output, context), context.watcher());
    return result;
  }
  const bool is_layout = options.step == JoinStep::layout;
  std::optional<JoinLayout> layout;
  if (is_layout) {
    require_joined_name(output);
    layout = laid_out(plan, options.join, context);
  } else {
    layout = find_layout(plan, local_storage(), output.path);
    if (!layout && is_joined(plan, local_storage(), output.path)) {
      result.file_bytes = local_storage().open_read(output.path)->size();
      result.is_done = true;
      return result;
    }
    if (!layout) {
      throw Error(ErrorKind::io, "nothing is laid out for this plan", output.path)
          .with_field("join.layout");
    }
    copy_numbers(options, plan, *layout, result, context);
  }
  result.file_bytes = layout->file_bytes;
  result.uncopied = uncopied_numbers(plan, *layout, output.path);
  return result;
}

JoinRuns join_runs(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  context.require_voxels(plan.source.size, options.plan);
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
