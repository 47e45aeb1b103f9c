#include "octavo/tasks/parts/join_scan.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "octavo/core/crc32c.h"
#include "octavo/core/error.h"
#include "octavo/core/text.h"
#include "octavo/dist/banded_group.h"
#include "octavo/dist/join_proof.h"
#include "octavo/dist/join_steps.h"
#include "octavo/file/storage/storage.h"
#include "octavo/tasks/inputs.h"
#include "octavo/tasks/outputs.h"
#include "octavo/tasks/parts/part_numbers.h"
#include "octavo/tasks/parts/part_places.h"
#include "octavo/tasks/parts/plan_file.h"
#include "octavo/tasks/parts/standing_part.h"

namespace octavo {

namespace {

/// The numbers of the parts that a join to `path` has copied.
std::set<std::int64_t> copied_numbers(const BuildPlan& plan, const std::string& path) {
  std::set<std::int64_t> numbers;
  const auto layout = find_layout(plan, local_storage(), path);
  if (!layout) return numbers;
  for (const PartPlace& place : parts_of(*layout)) {
    if (const auto number = part_at(plan, place)) numbers.insert(*number);
  }
  for (const PartPlace& place : uncopied_parts(*layout, local_storage(), path)) {
    if (const auto number = part_at(plan, place)) numbers.erase(*number);
  }
  return numbers;
}

/// The same without those whose bytes there were changed since.
std::set<std::int64_t> whole_copies(const BuildPlan& plan, const std::string& path,
                                    const TaskContext& context) {
  std::set<std::int64_t> whole;
  const auto layout = find_layout(plan, local_storage(), path);
  if (!layout) return whole;
  const auto file = local_storage().open_read(joined_name(path));
  if (!checksum_matches(crc_of_own_bytes(*layout, *file), layout->own_crc)) {
    context.note(joined_name(path) + ": is damaged where no part was copied");
    return whole;
  }
  std::vector<PartPlace> copied = parts_of(*layout);
  const CopiedMarks marks(*layout, local_storage(), path);
  std::erase_if(copied, [&](const PartPlace& place) { return !marks.hold(place); });
  for (const PartPlace& place : copied) {
    if (const auto number = part_at(plan, place)) whole.insert(*number);
  }
  for (const PartPlace& place :
       damaged_copies(*layout, copied, *file, context.thread_count(), context.watcher())) {
    const auto number = part_at(plan, place);
    if (!number) continue;
    whole.erase(*number);
    context.note(path + ": what was copied of part " + std::to_string(*number) +
                 " was changed since");
  }
  return whole;
}

/// As require_all_found; says so where a join has begun that holds parts which are gone.
void require_parts(const BuildPlan& plan, const std::map<std::int64_t, std::string>& found,
                   const PartPlaces& places, const JoinOptions& options) {
  try {
    require_all_found(plan, found, places, options.plan);
  } catch (const Error& error) {
    const std::set<std::int64_t> copied = copied_numbers(plan, options.output.path);
    const auto is_held = [&](std::int64_t part) { return !found.contains(part); };
    const auto held = std::ranges::count_if(copied, is_held);
    if (held == 0) throw;
    throw Error(error.kind(),
                error.detail() + "; a join that has begun here holds " + std::to_string(held) +
                    " of them",
                error.path())
        .with_field("join.consume");
  }
}

std::vector<std::string> paths_of(const std::map<std::int64_t, std::string>& parts) {
  std::vector<std::string> paths;
  for (const auto& [part, path] : parts) paths.push_back(path);
  return paths;
}

bool is_all_consumed(const BuildPlan& plan, const std::map<std::int64_t, std::string>& parts,
                     const Output& output) {
  return is_consumed(plan, paths_of(parts), local_storage(), output.path, output.overwrite);
}

/// The paths of all parts by number. Those that an earlier join has consumed need not be there.
std::map<std::int64_t, std::string> paths_of_all(const BuildPlan& plan,
                                                 const JoinOptions& options) {
  const PartPlaces places = places_of(options);
  const auto found = found_parts(plan, places, options.plan);
  require_no_part(options.output.path, found);
  if (!options.consumes_parts) {
    require_parts(plan, found, places, options);
  } else if (!is_all_consumed(plan, found, options.output)) {
    auto there = found;
    for (const std::int64_t part : copied_numbers(plan, options.output.path)) {
      there.emplace(part, "");
    }
    require_all_found(plan, there, places, options.plan);
  }
  return found;
}

/// The parts that a consuming join takes. What stands in the place of one that it has copied is
/// not needed: unless it is that part, it stays.
std::map<std::int64_t, std::string> parts_to_consume(
    const BuildPlan& plan, const std::map<std::int64_t, std::string>& parts,
    const std::string& output, const TaskContext& context) {
  const std::set<std::int64_t> copied = copied_numbers(plan, output);
  std::map<std::int64_t, std::string> taken;
  for (const auto& [part, path] : parts) {
    context.stop_if_cancelled();
    if (!local_storage().exists(path)) continue;
    try {
      if (copied.contains(part)) open_whole_part(plan, part, path);
      else open_part(plan, part, path);
    } catch (const Error& error) {
      if (!copied.contains(part) || error.kind() == ErrorKind::io) throw;
      context.note(std::string(error.what()) + ": it is left, the join holds that part");
      continue;
    }
    taken.emplace(part, path);
  }
  return taken;
}

BuiltVolume consume_planned(const BuildPlan& plan, std::map<std::int64_t, std::string> parts,
                            const JoinOptions& options, const TaskContext& context) {
  const Output& output = options.output;
  const auto start = std::chrono::steady_clock::now();
  BuiltVolume joined{plan.source, plan.options.kind, {}};
  BuildResult& build = joined.build;
  if (is_all_consumed(plan, parts, output)) {
    context.note(output.path + ": is joined already");
  } else {
    parts = parts_to_consume(plan, parts, output.path, context);
  }
  try {
    build.file_bytes =
        consume_parts(plan, paths_of(parts), local_storage(), output.path, output.overwrite,
                      join_work(output, context), context.watcher(), &build.clipped);
  } catch (const Error& error) {
    if (error.field() != "parts.missing") throw;
    throw error.with_field("parts.plan_path", options.plan);
  }
  const auto file = open_volume(output.path, context);
  const std::optional<CodingNote>& coding = file->description().metadata.facts().coding;
  build.raw_bytes = plane_bytes(plan.source) * static_cast<std::uint64_t>(plan.source.size.z);
  build.max_error = file->max_error();
  if (coding) build.detail_errors = coding->detail_errors;
  if (build.detail_errors) build.max_error = file->achieved_error();
  build.coding = file->description().coding;
  build.threads = context.thread_count();
  build.total_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return joined;
}

/// Proves what stands there of parts that may share a group.
void add_damaged(const BuildPlan& plan, const std::map<std::int64_t, std::string>& parts,
                 MissingParts& missing, const TaskContext& context) {
  const auto add = [&](std::int64_t part, const Error& error) {
    missing.missing.push_back({part, error.what()});
  };
  std::map<std::int64_t, std::shared_ptr<PartFile>> whole;
  for (const auto& [part, path] : parts) {
    context.stop_if_cancelled();
    try {
      whole.emplace(part, open_whole_part(plan, part, path));
    } catch (const Error& error) {
      context.note(error.what());
      add(part, error);
    }
  }
  if (plan.bands == 1) return;
  std::vector<std::shared_ptr<PartFile>> bands;
  for (const auto& [part, file] : whole) bands.push_back(file);
  try {
    require_one_group(bands);
  } catch (const Error& error) {
    // Nothing tells which of them has the voxels that count.
    context.note(error.what(), error.field());
    for (const auto& [part, file] : whole) add(part, error);
  }
}

}  // namespace

void require_joined_name(const Output& output) {
  if (!output.path.ends_with(".8vo")) {
    throw Error(ErrorKind::invalid_argument, "a join writes .8vo files", output.path)
        .with_field("output.format");
  }
  require_free(output);
}

void require_no_part(const std::string& output, const std::map<std::int64_t, std::string>& parts) {
  require_no_input(output, paths_of(parts));
}

PartWork join_work(const Output& output, const TaskContext& context) {
  return {context.threads, context.max_memory_bytes, clipped_listener(output.path, context)};
}

std::string MissingParts::list() const {
  std::vector<std::int64_t> numbers;
  for (const MissingPart& part : missing) numbers.push_back(part.number);
  return part_list_text(numbers);
}

BuiltVolume join_planned(const BuildPlan& plan, const std::map<std::int64_t, std::string>& paths,
                         const Output& output, const TaskContext& context) {
  std::vector<std::shared_ptr<PartFile>> parts;
  for (const auto& [part, path] : paths) {
    context.stop_if_cancelled();
    parts.push_back(open_part(plan, part, path));
  }
  BuiltVolume joined{plan.source, plan.options.kind, {}};
  joined.build = join_parts(plan, std::move(parts), local_storage(), output.path, output.overwrite,
                            join_work(output, context), context.watcher());
  discard_steps(plan, local_storage(), output.path);
  return joined;
}

BuiltVolume join_scan(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  context.require_voxels(plan.source.size, options.plan);
  const bool is_done =
      options.consumes_parts && is_joined(plan, local_storage(), options.output.path);
  if (!is_done) require_joined_name(options.output);
  const std::map<std::int64_t, std::string> paths = paths_of_all(plan, options);
  return options.consumes_parts ? consume_planned(plan, paths, options, context)
                                : join_planned(plan, paths, options.output, context);
}

MissingParts missing_parts(const JoinOptions& options, const TaskContext& context) {
  const BuildPlan plan = read_plan(options.plan);
  const PartPlaces places = places_of(options);
  std::map<std::int64_t, std::string> found;
  if (!places.folder.empty()) {
    found = found_parts(plan, places, options.plan);
  } else {
    for (const std::string& path : places.files) {
      try {
        found.emplace(number_of(plan, *PartFile::open(local_storage(), path)), path);
      } catch (const Error& error) {
        context.note(error.what());
      }
    }
  }
  MissingParts result{plan.part_count, {}};
  const std::string output =
      options.output.path.empty() ? proposed_volume(options.plan) : options.output.path;
  if (is_joined(plan, local_storage(), output)) return result;
  const std::set<std::int64_t> copied = whole_copies(plan, output, context);
  if (!copied.empty()) {
    const std::string held = counted_text(static_cast<std::int64_t>(copied.size()), "part");
    context.note(output + ": a join that has begun here holds " + held);
  }
  const ProgressScope scope(context.watcher(), "prove", plan.part_count, "parts");
  for (std::int64_t first = 0; first < plan.part_count; first += plan.bands) {
    std::map<std::int64_t, std::string> found_bands;
    for (std::int64_t part = first; part < first + plan.bands; ++part) {
      const auto path = found.find(part);
      if (path != found.end()) found_bands.emplace(*path);
      else if (!copied.contains(part)) result.missing.push_back({part, ""});
    }
    std::erase_if(found_bands, [&](const auto& band) { return copied.contains(band.first); });
    add_damaged(plan, found_bands, result, context);
    context.watcher().advance(plan.bands);
  }
  std::ranges::sort(result.missing, {}, &MissingPart::number);
  return result;
}

}  // namespace octavo
